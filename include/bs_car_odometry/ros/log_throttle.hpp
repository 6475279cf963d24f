#pragma once

#include "bs_car_odometry/core/odometry_pipeline.hpp"

#include <ros/time.h>

#include <array>
#include <cstddef>

namespace bs_car_odometry {

/// Lets one cause into the log once in a while, however often it comes. ROS' own throttles keep their time in
/// a static variable, which two cars in one manager would share.
class LogThrottle {
 public:
  /// True at most once in 5 s.
  bool isDue();

 private:
  ros::SteadyTime newest_;
};

/// Warns of dropped messages, once per cause in a while.
class DropLog {
 public:
  void warn(const char* topic, Verdict verdict, const InputCounts& counts);

 private:
  std::array<LogThrottle, static_cast<std::size_t>(Verdict::kCount)> throttles_;
};

}  // namespace bs_car_odometry
