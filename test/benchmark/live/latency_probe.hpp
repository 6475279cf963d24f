#pragma once

#include "bs_car_odometry/SteeringAngle.h"
#include "bs_car_odometry/WheelTicks.h"

#include <nav_msgs/Odometry.h>
#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <vector>

namespace bs_car_odometry::benchmarks {

/// The nodelets measured: the odometry, and two that only copy.
constexpr std::size_t kStreams = 3;
enum Stream : std::size_t { kOdometry, kCopy, kControl };

/// Time from publishing a message to receiving its answer [s], of every message, by stream.
using Latencies = std::array<std::vector<double>, kStreams>;

/// Publishes wheel ticks to the three in turn, a third of a period apart and in every order alike, and notes
/// when their answers arrive. The steering angle of a tick is there before it.
class LatencyProbe : public nodelet::Nodelet {
 public:
  /// Waits until all three nodelets listen. @return false when they do not within some seconds
  bool waitForConnections() const;

  /// @param rate [Hz], of each stream
  Latencies run(double rate, std::size_t messages);

 private:
  using SteadyTime = std::chrono::steady_clock::time_point;

  void onInit() override;
  void publish(Stream stream, std::size_t number, SteadyTime slot, std::chrono::nanoseconds period);
  void publishSteering(const ros::Time& stamp);
  void onOdometry(const nav_msgs::Odometry& message) { note(kOdometry, message.header.stamp); }
  void onCopy(const WheelTicks& message) { note(kCopy, message.header.stamp); }
  void onControl(const WheelTicks& message) { note(kControl, message.header.stamp); }
  void note(Stream stream, const ros::Time& stamp);

  std::array<ros::Publisher, kStreams> publishers_;
  ros::Publisher steering_publisher_;
  std::vector<ros::Subscriber> subscribers_;

  std::mutex mutex_;
  std::array<std::map<ros::Time, SteadyTime>, kStreams> sent_;  ///< not yet answered
  Latencies latencies_;
};

}  // namespace bs_car_odometry::benchmarks
