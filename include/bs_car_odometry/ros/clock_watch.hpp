#pragma once

#include "bs_car_odometry/core/time.hpp"
#include "bs_car_odometry/ros/log_throttle.hpp"

#include <ros/time.h>

namespace bs_car_odometry {

/// Notices a clock that does not run yet, and one that goes back. A step back by less than `max_future` is
/// harmless: stamps may be that far ahead anyway.
class ClockWatch {
 public:
  explicit ClockWatch(Duration max_future) : max_future_(max_future) {}

  /// False while simulated time is waited for, which goes to the log.
  bool runs(const ros::Time& now);

  /// True once for each step back, which goes to the log.
  bool wentBack(const ros::Time& now);

 private:
  Duration max_future_;
  Time newest_;
  LogThrottle not_running_;
  LogThrottle went_back_;
};

}  // namespace bs_car_odometry
