// The service ~relative_motion of a running odometry.

#include "odometry_client.hpp"

#include "bs_car_odometry/RelativeMotion.h"
#include "bs_car_odometry/core/se2.hpp"
#include "bs_car_odometry/ros/conversions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace bs_car_odometry::testing {
namespace {

using Response = RelativeMotion::Response;

// As in the launch file.
constexpr double kUnmeasured = 7.0;  // unmeasured_variance
constexpr double kHistory = 10.0;    // relative_motion/history [s]

Pose2 poseOf(const nav_msgs::Odometry& message) { return *toPose(message.pose.pose); }

class RelativeMotionService : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    client_ = std::make_unique<OdometryClient>("", "/odometry");
    ASSERT_TRUE(client_->connect());
    service_ = ros::NodeHandle().serviceClient<RelativeMotion>("odometry/relative_motion");
    ASSERT_TRUE(service_.waitForExistence(ros::Duration(20.0)));
  }
  static void TearDownTestSuite() { client_.reset(); }
  void SetUp() override { ASSERT_TRUE(client_->reset()); }
  void TearDown() override { EXPECT_TRUE(client_->processLives()) << "invariant 5"; }

  static Response ask(const ros::Time& from, const ros::Time& to) {
    RelativeMotion motion;
    motion.request.from = from;
    motion.request.to = to;
    EXPECT_TRUE(service_.call(motion)) << "the service answers whatever it is asked";
    for (const double entry : motion.response.motion.covariance) EXPECT_TRUE(std::isfinite(entry));
    return motion.response;
  }

  static void expectRefused(const Response& response, const std::string& reason) {
    EXPECT_FALSE(response.success);
    EXPECT_NE(response.message.find(reason), std::string::npos) << response.message;
  }

  /// A turn to the left, 10 mm a step; every message of it.
  static std::vector<nav_msgs::Odometry> drive(std::int64_t steps, std::int64_t first = 0) {
    std::vector<nav_msgs::Odometry> odometry;
    for (std::int64_t i = first; i <= first + steps; ++i) {
      const auto odom = client_->step({90 * i, 110 * i, 90 * i, 110 * i}, 0.1);
      EXPECT_TRUE(odom) << i;
      if (odom) odometry.push_back(*odom);
    }
    return odometry;
  }

  static std::unique_ptr<OdometryClient> client_;
  static ros::ServiceClient service_;
};

std::unique_ptr<OdometryClient> RelativeMotionService::client_;
ros::ServiceClient RelativeMotionService::service_;

TEST_F(RelativeMotionService, isTheMotionOfOdom) {
  const std::vector<nav_msgs::Odometry> odometry = drive(10);
  ASSERT_EQ(odometry.size(), 11u);
  for (const auto& [from, to] : {std::pair<std::size_t, std::size_t>(2, 9), {9, 2}, {0, 10}, {5, 5}}) {
    const Response response = ask(odometry[from].header.stamp, odometry[to].header.stamp);
    ASSERT_TRUE(response.success) << response.message;
    EXPECT_EQ(response.message, "");
    const Pose2 expected = inverse(poseOf(odometry[from])) * poseOf(odometry[to]);
    // A pose of some metres as a message, whose quaternion holds the yaw to 1e-15.
    EXPECT_NEAR(response.motion.pose.position.x, expected.x, 1e-13);
    EXPECT_NEAR(response.motion.pose.position.y, expected.y, 1e-13);
    EXPECT_NEAR(toPose(response.motion.pose)->yaw, expected.yaw, 1e-13);
    const double steps = std::abs(static_cast<double>(to) - static_cast<double>(from));
    EXPECT_NEAR(response.distance, 0.01 * steps, 1e-3 * 0.01 * steps) << "base_link is on the rear axle";
  }
}

TEST_F(RelativeMotionService, covarianceIsThatOfTheMotionAlone) {
  const std::vector<nav_msgs::Odometry> odometry = drive(10);
  const Response response = ask(odometry.front().header.stamp, odometry.back().header.stamp);
  ASSERT_TRUE(response.success);
  const auto& covariance = response.motion.covariance;
  EXPECT_TRUE(isCovariance(toPlanarCovariance(covariance)));
  EXPECT_GT(covariance[0], 0.0);
  EXPECT_LT(covariance[0], 1e-4) << "0.1 m; that of odom begins with 0.01 m^2";
  for (const std::size_t unmeasured : {14, 21, 28}) EXPECT_EQ(covariance[unmeasured], kUnmeasured);
  for (const std::size_t beside : {2, 3, 4, 8, 9, 10, 17, 23}) EXPECT_EQ(covariance[beside], 0.0);
  const Response nothing = ask(odometry.back().header.stamp, odometry.back().header.stamp);
  for (const std::size_t measured : {0, 1, 5, 7, 11, 35}) EXPECT_EQ(nothing.motion.covariance[measured], 0.0);
}

TEST_F(RelativeMotionService, stampsBetweenMessages) {
  const std::vector<nav_msgs::Odometry> odometry = drive(2);
  const ros::Duration step = odometry[2].header.stamp - odometry[1].header.stamp;
  const Response half = ask(odometry[1].header.stamp, odometry[1].header.stamp + step * 0.5);
  const Response whole = ask(odometry[1].header.stamp, odometry[2].header.stamp);
  ASSERT_TRUE(half.success && whole.success) << half.message << whole.message;
  // A stamp is a whole number of nanoseconds.
  EXPECT_NEAR(half.distance / whole.distance, 0.5, 1e-9 / step.toSec());
  EXPECT_NEAR(toPose(half.motion.pose)->yaw / toPose(whole.motion.pose)->yaw, 0.5, 1e-9 / step.toSec());
}

TEST_F(RelativeMotionService, setPoseChangesNothing) {
  const std::vector<nav_msgs::Odometry> before = drive(5);
  const Response expected = ask(before[1].header.stamp, before[4].header.stamp);
  geometry_msgs::PoseWithCovarianceStamped pose;
  pose.pose.pose.position.x = 50.0;
  pose.pose.pose.orientation.w = 1.0;
  client_->send(pose);
  ASSERT_TRUE(waitFor([] {
    client_->announceJump();
    const auto odom = client_->step({450, 550, 450, 550}, 0.1);
    return odom && odom->pose.pose.position.x == 50.0;
  }));
  EXPECT_EQ(ask(before[1].header.stamp, before[4].header.stamp), expected);
  const std::vector<nav_msgs::Odometry> after = drive(5, 5);
  const Response across = ask(before.front().header.stamp, after.back().header.stamp);
  ASSERT_TRUE(across.success) << across.message;
  EXPECT_NEAR(across.distance, 0.1, 1e-4);
}

TEST_F(RelativeMotionService, refusesBeforeThereIsAMotion) {
  expectRefused(ask(ros::Time::now(), ros::Time::now()), "no motion is known yet");
  const std::vector<nav_msgs::Odometry> first = drive(0);
  expectRefused(ask(first[0].header.stamp, first[0].header.stamp), "no motion is known yet");
}

TEST_F(RelativeMotionService, refusalsSayWhatTheHistorySpans) {
  const std::vector<nav_msgs::Odometry> odometry = drive(3);
  const ros::Time begin = odometry.front().header.stamp;
  const ros::Time end = odometry.back().header.stamp;
  std::ostringstream span;
  span << "spans " << begin << " to " << end;
  const ros::Duration tick(0, 1);
  expectRefused(ask(begin - tick, end), "from");
  expectRefused(ask(begin - tick, end), "before the history, which " + span.str());
  expectRefused(ask(begin, end + tick), "to (");
  expectRefused(ask(begin, end + tick), "after the history, which " + span.str());
  expectRefused(ask(end + tick, begin), "after the history, which " + span.str());
  EXPECT_TRUE(ask(begin, end).success) << "the stamps that a refusal names are answered";
}

TEST_F(RelativeMotionService, X2_hostileStamps) {
  const std::vector<nav_msgs::Odometry> odometry = drive(3);
  const ros::Time end = odometry.back().header.stamp;
  ros::Time irregular;
  irregular.sec = end.sec;
  irregular.nsec = 1000000000;
  expectRefused(ask(irregular, end), "from is no time");
  expectRefused(ask(end, irregular), "to is no time");
  ros::Time latest;
  latest.sec = std::numeric_limits<std::uint32_t>::max();
  latest.nsec = 999999999;
  for (const ros::Time& stamp : {ros::Time(), ros::Time(0, 1), latest}) {
    expectRefused(ask(stamp, end), "from (");
    expectRefused(ask(end, stamp), "to (");
    expectRefused(ask(stamp, stamp), "from (");
  }
}

TEST_F(RelativeMotionService, resetCutsTheHistory) {
  const std::vector<nav_msgs::Odometry> before = drive(3);
  ASSERT_TRUE(client_->reset());
  const std::vector<nav_msgs::Odometry> after = drive(3, 3);
  expectRefused(ask(before[1].header.stamp, after[3].header.stamp), "before the history");
  EXPECT_TRUE(ask(after[0].header.stamp, after[3].header.stamp).success);
}

TEST_F(RelativeMotionService, forgetsWhatIsTooOld) {
  const std::vector<nav_msgs::Odometry> first = drive(1);
  ASSERT_TRUE(ask(first[0].header.stamp, first[1].header.stamp).success);
  ASSERT_TRUE(waitFor([&] {
    const auto odom = client_->step({90, 110, 90, 110}, 0.1);
    return odom && odom->header.stamp - first[1].header.stamp > ros::Duration(kHistory);
  }));
  expectRefused(ask(first[0].header.stamp, first[1].header.stamp), "relative_motion/history");
}

TEST_F(RelativeMotionService, E2_saysWhatWasNotSeen) {
  const std::vector<nav_msgs::Odometry> before = drive(3);
  // The first one may be a spike; sent until the second one is taken as a restart.
  const auto after = client_->step({2000000000, 2000000000, 2000000000, 2000000000}, 0.1);
  ASSERT_TRUE(after);
  const Response response = ask(before[0].header.stamp, after->header.stamp);
  ASSERT_TRUE(response.success) << response.message;
  EXPECT_NE(response.message.find("not seen for"), std::string::npos) << response.message;
  EXPECT_EQ(ask(before[0].header.stamp, before[3].header.stamp).message, "");
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  return bs_car_odometry::testing::runTests(argc, argv, "relative_motion_test");
}
