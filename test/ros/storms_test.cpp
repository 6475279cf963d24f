// N11: storms of ~reset and set_pose take effect between steps only. P5: what changes on the parameter server
// has no effect. And no message can fill the log.

#include "odometry_client.hpp"
#include "restless_driver.hpp"
#include "support/figure.hpp"

#include <gtest/gtest.h>
#include <std_srvs/Trigger.h>

#include <cmath>
#include <limits>
#include <map>

namespace bs_car_odometry::testing {
namespace {

constexpr double kStep = 0.01;        // m, of each wheel message
constexpr double kWheelRate = 200.0;  // Hz
constexpr double kCallRate = 100.0;   // Hz
constexpr int kCalls = 1000;
constexpr double kInitialX = 1.0;
constexpr double kInitialY = -2.0;  // as in the launch file, where the heading is 0

/// Poses are set to (10 k, k): y says which, x how many steps ago.
struct Place {
  int call{0};  ///< none: the initial pose
  double steps{0.0};
};

Place placeOf(const nav_msgs::Odometry& message) {
  const auto& position = message.pose.pose.position;
  if (std::abs(position.y - kInitialY) < 1e-9) return {0, (position.x - kInitialX) / kStep};
  const double call = std::round(position.y);
  return {static_cast<int>(call), (position.x - 10.0 * call) / kStep};
}

geometry_msgs::PoseWithCovarianceStamped poseOfCall(int call) {
  geometry_msgs::PoseWithCovarianceStamped pose;
  pose.pose.pose.position.x = 10.0 * call;
  pose.pose.pose.position.y = call;
  pose.pose.pose.orientation.w = 1.0;
  for (const std::size_t i : {0, 7, 35}) pose.pose.covariance[i] = 0.25;
  return pose;
}

class Storms : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(reset_.waitForExistence(ros::Duration(20.0)));
    ASSERT_TRUE(
        waitFor([this] { return set_pose_.getNumSubscribers() > 0 && odom_.getNumPublishers() > 0; }));
    process_ = alive(kProcess);
    ASSERT_NE(process_, 0);
  }
  void TearDown() override { EXPECT_EQ(alive(kProcess), process_) << "invariant 5"; }

  bool reset() {
    std_srvs::Trigger trigger;
    return reset_.call(trigger) && trigger.response.success;
  }

  /// Every message is whole steps away from a pose that was set, with the covariance of so many steps.
  void check(const nav_msgs::Odometry& message) {
    invariants_.announceJump();
    EXPECT_EQ(invariants_.violation(message, ros::Time::now()), "") << message;
    const Place place = placeOf(message);
    const double steps = std::round(place.steps);
    ++seen_[place.call];
    EXPECT_NEAR(place.steps, steps, 1e-6) << message;
    EXPECT_GE(steps, 0.0);
    EXPECT_EQ(message.pose.pose.orientation.z, 0.0);
    const auto key = std::make_pair(place.call == 0, static_cast<int>(steps));
    const auto known = covariances_.emplace(key, message.pose.covariance).first;
    EXPECT_EQ(known->second, message.pose.covariance) << steps << " steps after call " << place.call;
  }

  static constexpr const char* kProcess = "/manager";
  ros::NodeHandle node_;
  ros::ServiceClient reset_{node_.serviceClient<std_srvs::Trigger>("odometry/reset")};
  ros::Publisher set_pose_{node_.advertise<geometry_msgs::PoseWithCovarianceStamped>("set_pose", 10)};
  ros::Subscriber odom_{node_.subscribe("odom", 5000, &Storms::check, this)};
  Invariants invariants_{InputLimits()};
  std::map<std::pair<bool, int>, boost::array<double, 36>> covariances_;
  std::map<int, int> seen_;  ///< messages of each pose that was set
  int process_{0};
};

TEST_F(Storms, N11_set_pose_and_reset_take_effect_between_steps_only) {
  ASSERT_TRUE(reset());
  const RestlessDriver drive(kWheelRate, 100, 0.0);
  ASSERT_TRUE(waitFor([&] { return seen_[0] > 10; }));
  ros::WallRate rate(kCallRate);
  for (int call = 1; call <= kCalls; ++call) {
    if (call % 2 == 0) {
      ASSERT_TRUE(reset()) << call;
    } else {
      set_pose_.publish(poseOfCall(call));
    }
    ros::spinOnce();
    rate.sleep();
  }
  // The last one that was set is where the car ends.
  set_pose_.publish(poseOfCall(kCalls + 1));
  EXPECT_TRUE(waitFor([&] { return seen_[kCalls + 1] > 10; }));
  // Each pose lasts until the reset that follows 10 ms later, two steps; a reset may overtake a pose.
  EXPECT_GT(seen_.size(), 0.3 * kCalls);
  recordFigure("%d calls at 100 Hz: every pose is whole steps after one that was set", kCalls);
}

TEST_F(Storms, P5_a_parameter_that_changes_has_no_effect) {
  ASSERT_TRUE(reset());
  for (const char* name : {"noise/wheel", "vehicle/wheelbase", "gains/rear/k_r", "gains/front/k_l",
                           "encoders/metres_per_tick/rear_left", "initial_pose/x", "max_speed"})
    ros::param::set(std::string("/odometry/") + name, 0.7);
  const RestlessDriver drive(kWheelRate, 100, 0.0);
  ASSERT_TRUE(waitFor([&] { return seen_[0] > 100; })) << "check() knows the steps and the initial pose";
  EXPECT_EQ(seen_.size(), 1u);
}

/// Each kind of message that is turned down, over and over.
TEST_F(Storms, N10_no_message_can_fill_the_log) {
  LogListener log;
  ASSERT_TRUE(waitFor([&] { return log.connected(); }));
  ros::Publisher wheels = node_.advertise<WheelTicks>("wheel_ticks", 100);
  ros::Publisher steering = node_.advertise<SteeringAngle>("front_steering", 100);
  ASSERT_TRUE(waitFor([&] { return wheels.getNumSubscribers() > 0 && steering.getNumSubscribers() > 0; }));
  odom_.shutdown();  // poses of random counters are no steps of 10 mm
  const ros::SteadyTime begin = ros::SteadyTime::now();
  std::int64_t count = 1;
  waitFor(
      [&] {
        for (int i = 0; i < 10; ++i) {
          const ros::Time now = ros::Time::now();
          count = count * 6364136223846793005 + 1442695040888963407;  // Knuth's generator
          wheels.publish(wheelTicks({count, -count, count / 3, 7}, now));
          wheels.publish(wheelTicks({1, 1, 1, 1}, i % 2 == 0 ? ros::Time() : now + ros::Duration(100.0)));
          wheels.publish(wheelTicks({1, 1, 1, 1}, now - ros::Duration(5.0)));
          steering.publish(steeringAngle(i % 2 == 0 ? 20.0 : std::numeric_limits<double>::infinity(), now));
          geometry_msgs::PoseWithCovarianceStamped pose = poseOfCall(1);
          if (i % 2 == 0) pose.header.frame_id = "map";
          set_pose_.publish(pose);
        }
        return false;
      },
      4.0);
  const double seconds = (ros::SteadyTime::now() - begin).toSec();
  // The last lines may be on their way.
  waitFor([] { return false; }, 0.5);
  const std::size_t lines = log.count("", 0);
  recordFigure("4 s of hostile messages: at most %.0f lines", roundedUp(static_cast<double>(lines)));
  EXPECT_GT(lines, 3u) << "they are turned down";
  // Eleven verdicts, and a dozen other causes, each once in 5 s.
  EXPECT_LT(static_cast<double>(lines), 25.0 * std::ceil(seconds / 5.0));
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) { return bs_car_odometry::testing::runTests(argc, argv, "storms_test"); }
