#pragma once

#include "odometry_client.hpp"

#include <atomic>
#include <cstdint>
#include <thread>

namespace bs_car_odometry::testing {

/// A driver that never rests, in a thread of its own: a car that drives on with every message.
class RestlessDriver {
 public:
  /// @param rate   of the messages [Hz]
  /// @param ticks  by which every counter grows with each
  /// @param angle  of the front axle [rad]
  RestlessDriver(double rate, std::int64_t ticks, double angle)
      : thread_([this, rate, ticks, angle] { run(rate, ticks, angle); }) {}
  ~RestlessDriver() {
    stopped_ = true;
    thread_.join();
  }
  RestlessDriver(const RestlessDriver&) = delete;
  RestlessDriver& operator=(const RestlessDriver&) = delete;

 private:
  void run(double rate, std::int64_t ticks, double angle) {
    std::int64_t count = 0;
    for (ros::WallRate pause(rate); !stopped_; pause.sleep()) {
      const ros::Time now = ros::Time::now();
      steering_.publish(steeringAngle(angle, now));
      count += ticks;
      wheels_.publish(wheelTicks({count, count, count, count}, now));
    }
  }

  ros::NodeHandle node_;
  ros::Publisher wheels_{node_.advertise<WheelTicks>("wheel_ticks", 100)};
  ros::Publisher steering_{node_.advertise<SteeringAngle>("front_steering", 100)};
  std::atomic<bool> stopped_{false};
  std::thread thread_;  // the last member: it uses all others
};

}  // namespace bs_car_odometry::testing
