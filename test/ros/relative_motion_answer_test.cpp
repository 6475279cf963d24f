// Answers and refusals of ~relative_motion, without a master.

#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/relative_motion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace bs_car_odometry {
namespace {

using ::testing::HasSubstr;

constexpr double kUnmeasured = 3.0;

Time at(double seconds) { return timeFromNanoseconds(1600000000000000000) + durationFromSeconds(seconds); }

MotionHistory emptyHistory(double seconds = 60.0) {
  return MotionHistory(durationFromSeconds(seconds), SystematicCovariance::Zero());
}

/// A quarter of a circle to the left in one second, 1 m long.
BodyIncrement quarter() {
  BodyIncrement increment;
  increment.motion = {1.0, 0.0, M_PI / 2};
  increment.path_covariance = Eigen::Vector3d(1e-4, 2e-4, 3e-4).asDiagonal();
  return increment;
}

MotionHistory oneQuarter() {
  MotionHistory history = emptyHistory();
  history.addStep({at(0), at(1)}, quarter(), {}, Eigen::Vector3d::Zero());
  return history;
}

RelativeMotion::Response ask(const MotionHistory& history, const ros::Time& from, const ros::Time& to) {
  RelativeMotion::Request request;
  request.from = from;
  request.to = to;
  RelativeMotion::Response response;
  response.message = "left over";
  response.distance = -1.0;
  fillRelativeMotion(history, kUnmeasured, request, response);
  return response;
}

RelativeMotion::Response ask(const MotionHistory& history, double from, double to) {
  return ask(history, toRos(at(from)), toRos(at(to)));
}

void expectRefused(const RelativeMotion::Response& response, const std::string& reason) {
  EXPECT_FALSE(response.success);
  EXPECT_THAT(response.message, HasSubstr(reason));
  EXPECT_EQ(response.distance, 0.0);
  EXPECT_EQ(response.motion.pose.orientation.w, 1.0) << "a valid pose, whoever forgets to look at success";
}

TEST(RelativeMotionAnswer, isTheMotionInTheAxesOfFrom) {
  const RelativeMotion::Response response = ask(oneQuarter(), 0.0, 1.0);
  EXPECT_TRUE(response.success);
  EXPECT_EQ(response.message, "");
  const double radius = 2.0 / M_PI;
  EXPECT_NEAR(response.motion.pose.position.x, radius, 1e-15);
  EXPECT_NEAR(response.motion.pose.position.y, radius, 1e-15);
  EXPECT_EQ(response.motion.pose.position.z, 0.0);
  EXPECT_NEAR(response.motion.pose.orientation.z, std::sqrt(0.5), 1e-15);
  EXPECT_EQ(response.distance, 1.0);
  const std::optional<MotionEstimate> expected = oneQuarter().between(at(0), at(1));
  EXPECT_EQ(response.motion.covariance, toCovariance(expected->covariance, kUnmeasured));
}

TEST(RelativeMotionAnswer, backwardsIsTheInverse) {
  const RelativeMotion::Response response = ask(oneQuarter(), 1.0, 0.0);
  EXPECT_TRUE(response.success);
  const double radius = 2.0 / M_PI;
  EXPECT_NEAR(response.motion.pose.position.x, -radius, 1e-15);
  EXPECT_NEAR(response.motion.pose.position.y, radius, 1e-15);
  EXPECT_NEAR(response.motion.pose.orientation.z, -std::sqrt(0.5), 1e-15);
}

TEST(RelativeMotionAnswer, saysWhatWasNotSeen) {
  MotionHistory history = oneQuarter();
  history.addUnseen({at(1), at(1.25)}, Eigen::Matrix3d::Identity());
  EXPECT_EQ(ask(history, 0.0, 1.0).message, "");
  const RelativeMotion::Response response = ask(history, 0.0, 1.25);
  EXPECT_TRUE(response.success);
  EXPECT_THAT(response.message, HasSubstr("not seen for 0.250 s"));
}

TEST(RelativeMotionRefusal, outsideTheSpan) {
  const std::string span = "spans 1600000000.000000000 to 1600000001.000000000";
  const RelativeMotion::Response before = ask(oneQuarter(), -0.5, 1.0);
  expectRefused(before, "from (1599999999.500000000) lies before the history, which " + span);
  EXPECT_THAT(before.message, HasSubstr("relative_motion/history"));
  const RelativeMotion::Response after = ask(oneQuarter(), 0.0, 1.5);
  expectRefused(after, "to (1600000001.500000000) lies after the history, which " + span);
  EXPECT_THAT(after.message, HasSubstr("once the wheel message after it has come"));
}

TEST(RelativeMotionRefusal, nothingKnown) {
  expectRefused(ask(emptyHistory(), 0.0, 1.0), "no motion is known yet");
}

TEST(RelativeMotionRefusal, nothingKept) {
  MotionHistory history = emptyHistory(0.0);
  history.addStep({at(0), at(1)}, quarter(), {}, Eigen::Vector3d::Zero());
  expectRefused(ask(history, 0.0, 1.0), "relative_motion/history is 0");
}

TEST(RelativeMotionRefusal, noTime) {
  ros::Time irregular;
  irregular.sec = 1600000000;
  irregular.nsec = 1000000000;
  const ros::Time regular = toRos(at(0.0));
  expectRefused(ask(oneQuarter(), irregular, regular), "from is no time");
  expectRefused(ask(oneQuarter(), regular, irregular), "to is no time");
}

TEST(RelativeMotionRefusal, notFinite) {
  MotionHistory history = emptyHistory();
  const Eigen::Matrix3d huge = 0.75 * std::numeric_limits<double>::max() * Eigen::Matrix3d::Identity();
  history.addUnseen({at(0), at(1)}, huge);
  history.addUnseen({at(1), at(2)}, huge);
  expectRefused(ask(history, 0.0, 2.0), "not finite");
}

}  // namespace
}  // namespace bs_car_odometry
