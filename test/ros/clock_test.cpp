// Simulated time: T8, a clock that nobody publishes, and T5, one that goes back as when a bag loops.

#include "odometry_client.hpp"

#include <gtest/gtest.h>
#include <rosgraph_msgs/Clock.h>

namespace bs_car_odometry::testing {
namespace {

/// Publishes the clock and drives the odometry by it.
class SimulatedTime {
 public:
  SimulatedTime()
      : clock_(node_.advertise<rosgraph_msgs::Clock>("/clock", 10)),
        wheels_(node_.advertise<WheelTicks>("wheel_ticks", 10)),
        steering_(node_.advertise<SteeringAngle>("front_steering", 10)),
        odom_(node_.subscribe("odom", 10, &SimulatedTime::onOdometry, this)) {}

  bool connect() {
    return waitFor([this] {
      return wheels_.getNumSubscribers() > 0 && steering_.getNumSubscribers() > 0 &&
             odom_.getNumPublishers() > 0;
    });
  }

  /// Sets the clock and sends readings of that time until their odometry is there.
  bool driveAt(double seconds, std::int64_t ticks) {
    const ros::Time now(seconds);
    return waitFor([&] {
      rosgraph_msgs::Clock clock;
      clock.clock = now;
      clock_.publish(clock);
      steering_.publish(steeringAngle(0.0, now));
      wheels_.publish(wheelTicks({ticks, ticks, ticks, ticks}, now));
      return !heard_.empty() && heard_.back().header.stamp == now;
    });
  }

  const nav_msgs::Odometry& newest() const { return heard_.back(); }
  bool silent() const { return heard_.empty(); }
  void sendWithoutClock() { wheels_.publish(wheelTicks({0, 0, 0, 0}, ros::Time(1.0))); }

 private:
  void onOdometry(const nav_msgs::Odometry& message) { heard_.push_back(message); }

  ros::NodeHandle node_;
  ros::Publisher clock_;
  ros::Publisher wheels_;
  ros::Publisher steering_;
  std::vector<nav_msgs::Odometry> heard_;
  ros::Subscriber odom_;
};

TEST(Clock, T8_nobody_publishes_the_clock_then_T5_it_goes_back) {
  SimulatedTime time;
  DiagnosticsListener diagnostics;
  ASSERT_TRUE(time.connect());
  time.sendWithoutClock();
  EXPECT_TRUE(diagnostics.waitForStatus("bs_car_odometry: Clock", diagnostic_msgs::DiagnosticStatus::ERROR,
                                        "waiting for /clock"));
  EXPECT_TRUE(time.silent());

  ASSERT_TRUE(time.driveAt(100.0, 0));
  ASSERT_TRUE(time.driveAt(100.1, 2000));
  ASSERT_TRUE(time.driveAt(100.2, 4000));
  const nav_msgs::Odometry first_run = time.newest();
  EXPECT_NEAR(first_run.pose.pose.position.x, 0.4, 1e-9);

  ASSERT_TRUE(time.driveAt(50.0, 70000));
  EXPECT_EQ(time.newest().pose.pose.position.x, 0.0) << "a new run begins at the initial pose";
  ASSERT_TRUE(time.driveAt(50.1, 72000));
  ASSERT_TRUE(time.driveAt(50.2, 74000));
  EXPECT_EQ(time.newest().pose.pose.position.x, first_run.pose.pose.position.x);
  EXPECT_EQ(time.newest().pose.covariance, first_run.pose.covariance);
  EXPECT_EQ(time.newest().twist.covariance, first_run.twist.covariance);
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) { return bs_car_odometry::testing::runTests(argc, argv, "clock_test"); }
