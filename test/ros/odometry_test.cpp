// A running odometry, nodelet or node: what it publishes, and that nothing it is sent can disturb it.

#include "odometry_client.hpp"

#include <gtest/gtest.h>
#include <std_srvs/Trigger.h>

#include <cmath>
#include <limits>
#include <memory>

namespace bs_car_odometry::testing {
namespace {

using Pose = geometry_msgs::PoseWithCovarianceStamped;

// As in the launch files.
constexpr double kInitialX = 1.0;
constexpr double kInitialY = -2.0;
constexpr double kInitialYaw = 0.5;

constexpr std::size_t kBatch = 100;  // messages between two steps, fewer than the odometry's queue holds

double yawOf(const nav_msgs::Odometry& message) {
  return 2.0 * std::atan2(message.pose.pose.orientation.z, message.pose.pose.orientation.w);
}

Pose poseAt(double x, double variance = 0.01) {
  Pose pose;
  pose.pose.pose.position.x = x;
  pose.pose.pose.orientation.w = 1.0;
  for (const std::size_t i : {0, 7, 35}) pose.pose.covariance[i] = variance;
  return pose;
}

/// All fields of a stamp as they stand, without the arithmetic that would make them regular.
ros::Time rawStamp(std::uint32_t sec, std::uint32_t nsec) {
  ros::Time stamp;
  stamp.sec = sec;
  stamp.nsec = nsec;
  return stamp;
}

std::vector<ros::Time> hostileStamps() {
  std::vector<ros::Time> stamps{rawStamp(0, 0), rawStamp(0, 1), rawStamp(~0u, ~0u), rawStamp(~0u, 999999999)};
  const ros::Time now = ros::Time::now();
  for (int bit = 0; bit < 32; ++bit) {
    const std::uint32_t power = 1u << bit;
    stamps.push_back(rawStamp(power, 0));
    stamps.push_back(rawStamp(0, power));
    stamps.push_back(rawStamp(now.sec, power));
    stamps.push_back(rawStamp(power, power));
  }
  return stamps;
}

std::vector<double> hostileNumbers() {
  const double infinity = std::numeric_limits<double>::infinity();
  const double largest = std::numeric_limits<double>::max();
  return {std::nan(""), -std::nan(""), infinity, -infinity, largest,  -largest,
          5e-324,       -0.0,          1e19,     M_PI / 2,  1.3000001};
}

std::vector<std::int64_t> hostileCounts() {
  std::vector<std::int64_t> counts{std::numeric_limits<std::int64_t>::min(),
                                   std::numeric_limits<std::int64_t>::max()};
  for (int bit = 0; bit < 63; bit += 3) {
    counts.push_back(std::int64_t{1} << bit);
    counts.push_back(-(std::int64_t{1} << bit));
  }
  return counts;
}

std::vector<Pose> hostilePoses() {
  std::vector<Pose> poses;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (const std::size_t i : {0, 1, 7, 35}) {
      poses.push_back(poseAt(500.0));
      poses.back().pose.covariance[i] = bad;
    }
    poses.push_back(poseAt(bad));
    poses.push_back(poseAt(500.0));
    poses.back().pose.pose.orientation.z = bad;
  }
  poses.push_back(poseAt(500.0, -1.0));
  poses.push_back(poseAt(500.0));
  poses.back().pose.covariance[1] = poses.back().pose.covariance[6] = 1.0;
  poses.push_back(poseAt(500.0));
  poses.back().pose.pose.orientation.w = 0.0;
  poses.push_back(poseAt(500.0));
  poses.back().header.frame_id = "map";
  return poses;
}

class Odometry : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const std::string process = ros::param::param<std::string>("~process", "/odometry");
    client_ = std::make_unique<OdometryClient>("", process);
    diagnostics_ = std::make_unique<DiagnosticsListener>();
    ASSERT_TRUE(client_->connect()) << process;
  }
  static void TearDownTestSuite() {
    client_.reset();
    diagnostics_.reset();
  }
  void SetUp() override { ASSERT_TRUE(client_->reset()); }
  void TearDown() override { EXPECT_TRUE(client_->processLives()) << "invariant 5"; }

  /// The odometry still does what it should: 10 mm ahead.
  static void expectSound(std::int64_t ticks) {
    const auto before = client_->step({ticks, ticks, ticks, ticks});
    ASSERT_TRUE(before);
    const std::int64_t ahead = ticks + 100;
    const auto after = client_->step({ahead, ahead, ahead, ahead});
    ASSERT_TRUE(after);
    // After what contradicts it the odometry may do without the angle: the direction is then the wheels' own.
    EXPECT_NEAR(std::hypot(after->pose.pose.position.x - before->pose.pose.position.x,
                           after->pose.pose.position.y - before->pose.pose.position.y),
                0.01, 1e-5);
  }

  /// Sends messages, a step of the parked car after every few.
  template <typename Message>
  static void sendAll(const std::vector<Message>& messages, const Ticks& parked) {
    for (std::size_t i = 0; i < messages.size(); ++i) {
      client_->send(messages[i]);
      if (i % kBatch == kBatch - 1) {
        ASSERT_TRUE(client_->step(parked).has_value());
      }
    }
    ASSERT_TRUE(client_->step(parked).has_value());
  }

  static std::unique_ptr<OdometryClient> client_;
  static std::unique_ptr<DiagnosticsListener> diagnostics_;
};

std::unique_ptr<OdometryClient> Odometry::client_;
std::unique_ptr<DiagnosticsListener> Odometry::diagnostics_;

TEST_F(Odometry, E4_first_message_is_the_initial_pose) {
  const auto first = client_->step({7, -8, 123456789, 4000000000});
  ASSERT_TRUE(first);
  EXPECT_EQ(first->header.frame_id, "odom");
  EXPECT_EQ(first->child_frame_id, "base_link");
  EXPECT_EQ(first->pose.pose.position.x, kInitialX);
  EXPECT_EQ(first->pose.pose.position.y, kInitialY);
  EXPECT_NEAR(yawOf(*first), kInitialYaw, 1e-15);
  EXPECT_EQ(first->pose.covariance[0], 0.01);
  EXPECT_EQ(first->pose.covariance[7], 0.02);
  EXPECT_EQ(first->pose.covariance[35], 0.03);
  EXPECT_EQ(first->twist.twist.linear.x, 0.0);
  EXPECT_EQ(first->twist.covariance[0], 1600.0) << "max_speed^2: not known";
}

TEST_F(Odometry, straightAheadAtHalfAMetrePerSecond) {
  ASSERT_TRUE(client_->step({0, 0, 0, 0}));
  std::optional<nav_msgs::Odometry> last;
  for (std::int64_t i = 1; i <= 20; ++i) last = client_->step({100 * i, 100 * i, 100 * i, 100 * i});
  ASSERT_TRUE(last);
  EXPECT_NEAR(last->pose.pose.position.x, kInitialX + 0.2 * std::cos(kInitialYaw), 1e-9);
  EXPECT_NEAR(last->pose.pose.position.y, kInitialY + 0.2 * std::sin(kInitialYaw), 1e-9);
  EXPECT_GT(last->twist.twist.linear.x, 0.0);
  EXPECT_GT(last->pose.covariance[0], 0.01);
  EXPECT_NEAR(client_->status().distance, 0.2, 1e-9);
  EXPECT_EQ(client_->status().wheel_messages, 21u);
}

TEST_F(Odometry, transformIsThePose) {
  ASSERT_TRUE(waitFor([&] { return client_->hearsTransforms(); }));
  ASSERT_TRUE(client_->step({0, 0, 0, 0}));
  const auto odom = client_->step({900, 1000, 900, 1000}, 0.1);
  ASSERT_TRUE(odom);
  ASSERT_TRUE(waitFor([&] {
    return !client_->transforms().empty() && client_->transforms().back().header.stamp == odom->header.stamp;
  }));
  const geometry_msgs::TransformStamped& transform = client_->transforms().back();
  EXPECT_EQ(transform.header.frame_id, "odom");
  EXPECT_EQ(transform.child_frame_id, "base_link");
  EXPECT_EQ(transform.transform.translation.x, odom->pose.pose.position.x);
  EXPECT_EQ(transform.transform.translation.y, odom->pose.pose.position.y);
  EXPECT_EQ(transform.transform.rotation, odom->pose.pose.orientation);
}

TEST_F(Odometry, T9_hostile_stamps) {
  ASSERT_TRUE(client_->step({0, 0, 0, 0}));
  std::vector<WheelTicks> wheels;
  std::vector<SteeringAngle> steering;
  for (const ros::Time& stamp : hostileStamps()) {
    wheels.push_back(wheelTicks({5, 5, 5, 5}, stamp));
    steering.push_back(steeringAngle(0.0, stamp));
  }
  sendAll(wheels, {5, 5, 5, 5});
  sendAll(steering, {5, 5, 5, 5});
  EXPECT_GT(client_->status().dropped_stamp_invalid, 0u);
  EXPECT_GT(client_->status().dropped_future, 0u);
  expectSound(5);
}

TEST_F(Odometry, S1_hostile_angles) {
  ASSERT_TRUE(client_->step({0, 0, 0, 0}));
  for (const double angle : hostileNumbers()) {
    const ros::Time now = ros::Time::now();
    client_->send(steeringAngle(angle, now));
    client_->send(wheelTicks({0, 0, 0, 0}, now));
  }
  ASSERT_TRUE(client_->step({0, 0, 0, 0}));
  ASSERT_TRUE(waitFor([] {
    const bool stepped = client_->step({0, 0, 0, 0}).has_value();
    return stepped && client_->status().dropped_not_finite >= 4u;
  }));
  expectSound(0);
}

TEST_F(Odometry, E1_hostile_counters) {
  ASSERT_TRUE(client_->step({0, 0, 0, 0}));
  for (const std::int64_t count : hostileCounts())
    for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
      Ticks ticks{0, 0, 0, 0};
      ticks[wheel] = count;
      const ros::Time now = ros::Time::now();
      client_->send(steeringAngle(0.0, now));
      client_->send(wheelTicks(ticks, now));
    }
  // One more than a restart takes.
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(client_->step({0, 0, 0, 0}));
  expectSound(0);
}

TEST_F(Odometry, C1_hostile_poses_are_refused) {
  ASSERT_TRUE(client_->step({0, 0, 0, 0}));
  sendAll(hostilePoses(), {0, 0, 0, 0});
  // What comes later on the same topic has been heard after them.
  client_->send(poseAt(5.0));
  ASSERT_TRUE(waitFor([] {
    client_->announceJump();
    const auto odom = client_->step({0, 0, 0, 0});
    return odom && odom->pose.pose.position.x == 5.0;
  }));
  for (const nav_msgs::Odometry& odom : client_->odometry()) ASSERT_NE(odom.pose.pose.position.x, 500.0);
}

TEST_F(Odometry, setPosePutsTheCarThere) {
  ASSERT_TRUE(client_->step({0, 0, 0, 0}));
  Pose pose = poseAt(20.0, 0.25);
  pose.header.frame_id = "odom";
  pose.pose.pose.orientation.z = pose.pose.pose.orientation.w = std::sqrt(0.5);
  client_->send(pose);
  std::optional<nav_msgs::Odometry> odom;
  ASSERT_TRUE(waitFor([&] {
    client_->announceJump();
    odom = client_->step({0, 0, 0, 0});
    return odom && odom->pose.pose.position.x == 20.0;
  }));
  EXPECT_EQ(odom->pose.covariance[0], 0.25);
  EXPECT_NEAR(yawOf(*odom), M_PI / 2, 1e-12);
  const auto ahead = client_->step({100, 100, 100, 100});
  ASSERT_TRUE(ahead);
  EXPECT_NEAR(ahead->pose.pose.position.y, 0.01, 1e-9);
}

TEST_F(Odometry, O2_covariance_of_set_pose_is_published_without_negative_eigenvalues) {
  Pose pose = poseAt(30.0, 1.0);
  pose.pose.covariance[1] = pose.pose.covariance[6] = 1.0 + 4e-10;
  client_->send(pose);
  ASSERT_TRUE(waitFor([] {
    client_->announceJump();
    const auto odom = client_->step({0, 0, 0, 0});
    return odom && odom->pose.pose.position.x == 30.0;
  })) << "rounding of the sender is accepted; the invariants say whether it is published";
}

TEST_F(Odometry, resetGoesBackToTheInitialPose) {
  ASSERT_TRUE(client_->step({0, 0, 0, 0}));
  ASSERT_TRUE(client_->step({500, 500, 500, 500}));
  ASSERT_TRUE(client_->reset());
  const auto first = client_->step({9999, 9999, 9999, 9999});
  ASSERT_TRUE(first);
  EXPECT_EQ(first->pose.pose.position.x, kInitialX);
  EXPECT_EQ(first->pose.covariance[0], 0.01);
  EXPECT_EQ(client_->status().distance, 0.0);
  EXPECT_EQ(client_->status().wheel_messages, 1u);
}

TEST_F(Odometry, T1_diagnostics_name_the_remedy) {
  ASSERT_TRUE(client_->step({0, 0, 0, 0}));
  client_->send(wheelTicks({1, 1, 1, 1}, ros::Time()));
  EXPECT_TRUE(diagnostics_->waitForStatus("bs_car_odometry: Clock", diagnostic_msgs::DiagnosticStatus::ERROR,
                                          "stamp_source: receipt"));
}

TEST_F(Odometry, T4_future_stamp_is_dropped) {
  ASSERT_TRUE(client_->step({0, 0, 0, 0}));
  const ros::Time ahead = ros::Time::now() + ros::Duration(3600.0);
  client_->send(steeringAngle(0.0, ahead));
  client_->send(wheelTicks({1, 1, 1, 1}, ahead));
  EXPECT_TRUE(diagnostics_->waitForStatus("bs_car_odometry: Clock", diagnostic_msgs::DiagnosticStatus::WARN,
                                          "(by 3"));
  expectSound(0);
  for (const nav_msgs::Odometry& odom : client_->odometry()) ASSERT_LT(odom.header.stamp, ahead);
  for (const geometry_msgs::TransformStamped& transform : client_->transforms())
    ASSERT_LT(transform.header.stamp, ahead);
}

TEST_F(Odometry, diagnosticsComeOnceASecond) {
  for (const char* part : {"Encoders", "Steering", "Clock", "Output"}) {
    const std::string name = std::string("bs_car_odometry: ") + part;
    ASSERT_TRUE(waitFor([&] { return diagnostics_->timesOf(name).size() >= 4; })) << name;
    const std::vector<ros::SteadyTime> times = diagnostics_->timesOf(name);
    const double period = (times.back() - times[1]).toSec() / static_cast<double>(times.size() - 2);
    EXPECT_NEAR(period, 1.0, 0.3) << name;
  }
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) { return bs_car_odometry::testing::runTests(argc, argv, "odometry_test"); }
