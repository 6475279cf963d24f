// soak_driver: drives a car with wheels and steering at 1 kHz, and gives back to the calibration what the
// odometry says as the poses of a laser. Says every second how old the odometries were that it has heard
// [us]: from before the wheels were published until the odometry was heard.

#include "ros/restless_driver.hpp"

#include <cstdint>
#include <iostream>
#include <string>
#include <vector>

namespace bs_car_odometry::testing {
namespace {

constexpr double kRate = 1000.0;                // Hz
constexpr std::int64_t kTicks = 10;             // 1 m/s with the Cycab's 0.1 mm a tick
constexpr double kAngle = 0.0;                  // rad: every wheel counts the same
constexpr std::size_t kOdometriesALaser = 100;  // 10 Hz
constexpr std::uint32_t kQueueSize = 1000;      // a second
constexpr double kSigma = 0.02;                 // m and rad, of the laser

class Listener {
 public:
  void onOdometry(const nav_msgs::Odometry& message) {
    ages_.push_back((ros::Time::now() - message.header.stamp).toNSec() / 1000);
    if (++heard_ % kOdometriesALaser == 0) sendLaser(message);
  }

  /// What the last second was like.
  void report() {
    std::string line = "soak";
    for (const std::int64_t age : ages_) line += ' ' + std::to_string(age);
    line += '\n';
    std::cout << line << std::flush;  // at once: ROS writes its own lines between them
    ages_.clear();
  }

 private:
  void sendLaser(const nav_msgs::Odometry& odometry) {
    geometry_msgs::PoseWithCovarianceStamped laser;
    laser.header.stamp = odometry.header.stamp;
    laser.header.frame_id = "map";
    laser.pose.pose = odometry.pose.pose;
    for (const std::size_t element : {0, 7, 35}) laser.pose.covariance[element] = kSigma * kSigma;
    laser_.publish(laser);
  }

  ros::NodeHandle node_;
  ros::Publisher laser_{node_.advertise<geometry_msgs::PoseWithCovarianceStamped>("laser_pose", kQueueSize)};
  ros::Subscriber odom_{
      node_.subscribe("odom", kQueueSize, &Listener::onOdometry, this, ros::TransportHints().tcpNoDelay())};
  std::vector<std::int64_t> ages_;  // us, since the last report
  std::size_t heard_{0};
};

void soak() {
  Listener listener;
  const RestlessDriver driver(kRate, kTicks, kAngle);
  const ros::WallTimer timer = ros::NodeHandle().createWallTimer(
      ros::WallDuration(1.0), [&](const ros::WallTimerEvent&) { listener.report(); });
  ros::spin();
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  ros::init(argc, argv, "soak_driver");
  bs_car_odometry::testing::soak();
  return 0;
}
