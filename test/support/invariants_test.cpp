// The checker of the invariants: a good message passes, a violation of each is caught.

#include "support/invariants.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>

namespace bs_car_odometry::testing {
namespace {

using ::testing::StartsWith;
using Change = std::function<void(nav_msgs::Odometry&)>;

const ros::Time kNow(1000, 0);

nav_msgs::Odometry good(double stamp = 999.9) {
  nav_msgs::Odometry message;
  message.header.stamp.fromSec(stamp);
  message.pose.pose.orientation.w = 1.0;
  for (const std::size_t i : {0, 7, 35}) message.pose.covariance[i] = message.twist.covariance[i] = 0.01;
  return message;
}

OdometryStatus statusOf(const nav_msgs::Odometry& odometry, std::uint64_t number) {
  OdometryStatus status;
  status.header = odometry.header;
  status.state = OdometryStatus::NOMINAL;
  status.wheel_messages = number;
  return status;
}

InputLimits limits() {
  InputLimits limits;
  limits.max_speed = 5.0;
  return limits;
}

/// The violation of a good message after this change.
std::string violationOf(const Change& change) {
  Invariants invariants(limits());
  EXPECT_EQ(invariants.violation(good(), kNow), "");
  nav_msgs::Odometry message = good(999.95);
  change(message);
  return invariants.violation(message, kNow);
}

TEST(InvariantsTest, goodMessagesPass) {
  Invariants invariants(limits());
  for (int i = 0; i < 10; ++i) {
    nav_msgs::Odometry message = good(999.0 + 0.1 * i);
    message.pose.pose.position.x = 0.5 * i;
    EXPECT_EQ(invariants.violation(message, kNow), "");
    EXPECT_EQ(invariants.violation(statusOf(message, static_cast<std::uint64_t>(i + 1))), "");
  }
}

TEST(InvariantsTest, covariancesOfAnyScalePass) {
  for (const double scale : {0.0, 1e-300, 1e-12, 1e12, 1e300})
    EXPECT_EQ(violationOf([&](auto& m) {
                for (double& value : m.pose.covariance) value *= scale;
              }),
              "");
}

TEST(InvariantsTest, everyNumberMustBeFinite) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THAT(violationOf([&](auto& m) { m.pose.pose.position.y = bad; }), StartsWith("1:"));
    EXPECT_THAT(violationOf([&](auto& m) { m.pose.pose.orientation.z = bad; }), StartsWith("1:"));
    EXPECT_THAT(violationOf([&](auto& m) { m.twist.twist.angular.z = bad; }), StartsWith("1:"));
    EXPECT_THAT(violationOf([&](auto& m) { m.pose.covariance[8] = bad; }), StartsWith("1:"));
    EXPECT_THAT(violationOf([&](auto& m) { m.twist.covariance[35] = bad; }), StartsWith("1:"));
  }
}

TEST(InvariantsTest, quaternionMustBeOfUnitLength) {
  EXPECT_THAT(violationOf([](auto& m) { m.pose.pose.orientation.w = 1.0 + 2e-9; }), StartsWith("1:"));
  EXPECT_THAT(violationOf([](auto& m) { m.pose.pose.orientation.w = 0.0; }), StartsWith("1:"));
}

TEST(InvariantsTest, covariancesMustBeSymmetric) {
  EXPECT_THAT(violationOf([](auto& m) { m.pose.covariance[1] = 1e-18; }), StartsWith("2: the pose"));
  EXPECT_THAT(violationOf([](auto& m) { m.twist.covariance[5] = 1e-18; }), StartsWith("2: the twist"));
}

TEST(InvariantsTest, covariancesMustBePositiveSemidefinite) {
  EXPECT_THAT(violationOf([](auto& m) { m.pose.covariance[35] = -1e-13; }), StartsWith("2: the pose"));
  EXPECT_THAT(violationOf([](auto& m) { m.twist.covariance[1] = m.twist.covariance[6] = 0.011; }),
              StartsWith("2: the twist"));
}

TEST(InvariantsTest, stampsMustIncreaseAndStayBehindTheClock) {
  EXPECT_THAT(violationOf([](auto& m) { m.header.stamp = good().header.stamp; }), StartsWith("3:"));
  EXPECT_THAT(violationOf([](auto& m) { m.header.stamp = ros::Time(10, 0); }), StartsWith("3:"));
  EXPECT_THAT(violationOf([](auto& m) { m.header.stamp = ros::Time(1000, 110000000); }), StartsWith("3:"));
  EXPECT_EQ(violationOf([](auto& m) { m.header.stamp = ros::Time(1000, 90000000); }), "");
  EXPECT_THAT(violationOf([](auto& m) { m.header.stamp.nsec = 1000000000; }), StartsWith("3:"));
}

TEST(InvariantsTest, aNewRunMayBeginEarlier) {
  Invariants invariants(limits());
  EXPECT_EQ(invariants.violation(good(999.9), kNow), "");
  invariants.announceNewRun();
  EXPECT_EQ(invariants.violation(good(10.0), kNow), "");
}

TEST(InvariantsTest, stepsMustBePossibleUnlessAnnounced) {
  EXPECT_THAT(violationOf([](auto& m) { m.pose.pose.position.x = 1.0; }), StartsWith("4:"));
  EXPECT_EQ(violationOf([](auto& m) { m.pose.pose.position.x = 0.4; }), "");
  Invariants invariants(limits());
  EXPECT_EQ(invariants.violation(good(999.9), kNow), "");
  invariants.announceJump();
  nav_msgs::Odometry there = good(999.95);
  there.pose.pose.position.x = 100.0;
  EXPECT_EQ(invariants.violation(there, kNow), "");
}

/// The violation of the second of two statuses, changed.
std::string statusViolation(const std::function<void(nav_msgs::Odometry&, OdometryStatus&)>& change) {
  Invariants invariants(limits());
  EXPECT_EQ(invariants.violation(good(), kNow), "");
  EXPECT_EQ(invariants.violation(statusOf(good(), 1)), "");
  nav_msgs::Odometry message = good(999.95);
  OdometryStatus status = statusOf(message, 2);
  change(message, status);
  EXPECT_EQ(invariants.violation(message, kNow), "");
  return invariants.violation(status);
}

TEST(InvariantsTest, degradedDataMustSaySo) {
  EXPECT_EQ(statusViolation([](auto&, auto&) {}), "");
  EXPECT_THAT(statusViolation([](auto&, auto& s) { s.state = OdometryStatus::DEGRADED; }), StartsWith("6:"));
  EXPECT_THAT(statusViolation([](auto&, auto& s) { s.reason = "because"; }), StartsWith("6:"));
  EXPECT_THAT(statusViolation([](auto&, auto& s) { s.gaps = 1; }), StartsWith("6:"));
  EXPECT_THAT(statusViolation([](auto& m, auto& s) {
                m.pose.covariance[0] = 1.0;
                s.refused_states = 1;
              }),
              StartsWith("6: a refused state"));
  EXPECT_THAT(statusViolation([](auto&, auto& s) { s.header.stamp = ros::Time(1, 0); }), StartsWith("6:"));
}

/// 50 ms between the statuses, the last 20 of them seen: at 5 m/s 0.15 m each way were not.
std::string restartViolation(double variance, double step, double yaw_variance = 0.0) {
  return statusViolation([&](auto& m, auto& s) {
    m.pose.covariance[0] = m.pose.covariance[7] = variance;
    m.pose.covariance[35] = yaw_variance;
    m.twist.covariance[35] = 0.0;
    s.counter_restarts = 1;
    s.interval = 0.02;
    s.step = step;
  });
}

TEST(InvariantsTest, unseenMotionMustBeInTheCovariance) {
  constexpr double kBefore = 0.01;
  constexpr double kUnseen = 0.15 * 0.15;
  EXPECT_THAT(restartViolation(kBefore, 0.0), StartsWith("6: the covariance lacks"));
  EXPECT_THAT(restartViolation(kBefore + 0.99 * kUnseen, 0.0), StartsWith("6: the covariance lacks"));
  EXPECT_EQ(restartViolation(kBefore + 1.01 * kUnseen, 0.0), "");
}

/// A heading that is known to 1 rad turns a step of 0.1 m by as much: the error may be 0.1 m less. That of
/// the twist, 0.1 m/s each way, takes 3 mm more.
TEST(InvariantsTest, onlyTheStepMayTakeUncertaintyAway) {
  const auto variance = [](double less) { return 0.5 * std::pow(std::sqrt(2.0 * 0.0325) - less, 2); };
  EXPECT_EQ(restartViolation(variance(0.102), 0.1, 1.0), "");
  EXPECT_THAT(restartViolation(variance(0.104), 0.1, 1.0), StartsWith("6: the covariance lacks"));
  EXPECT_THAT(restartViolation(variance(0.1), 0.1, 0.01), StartsWith("6: the covariance lacks"));
}

TEST(InvariantsTest, theMotionOfARefusedStateMustBeInTheCovariance) {
  const auto refused = [](double variance) {
    return statusViolation([&](auto& m, auto& s) {
      m.pose.covariance[0] = m.pose.covariance[7] = variance;
      s.state = OdometryStatus::DEGRADED;
      s.reason = "because";
      s.interval = 0.05;
      s.refused_states = 1;
    });
  };
  constexpr double kUnseen = 0.25 * 0.25;
  EXPECT_THAT(refused(0.01 + 0.99 * kUnseen), StartsWith("6: the covariance lacks"));
  EXPECT_EQ(refused(0.01 + 1.01 * kUnseen), "");
}

TEST(InvariantsTest, anAnnouncedJumpMayTakeUncertaintyAway) {
  Invariants invariants(limits());
  EXPECT_EQ(invariants.violation(good(), kNow), "");
  EXPECT_EQ(invariants.violation(statusOf(good(), 1)), "");
  invariants.announceJump();
  const nav_msgs::Odometry message = good(999.95);
  OdometryStatus status = statusOf(message, 2);
  status.counter_restarts = 1;
  EXPECT_EQ(invariants.violation(message, kNow), "");
  EXPECT_EQ(invariants.violation(status), "");
}

}  // namespace
}  // namespace bs_car_odometry::testing
