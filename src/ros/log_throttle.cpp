#include "bs_car_odometry/ros/log_throttle.hpp"

#include "bs_car_odometry/ros/verdicts.hpp"

#include <ros/console.h>

namespace bs_car_odometry {

bool LogThrottle::isDue() {
  constexpr double kPeriod = 5.0;  // [s]
  const ros::SteadyTime now = ros::SteadyTime::now();
  if (!newest_.isZero() && (now - newest_).toSec() < kPeriod) return false;
  newest_ = now;
  return true;
}

void DropLog::warn(const char* topic, Verdict verdict, const InputCounts& counts) {
  if (verdict == Verdict::kAccepted || !throttles_[static_cast<std::size_t>(verdict)].isDue()) return;
  const std::string text = std::string("message on ") + topic + " dropped: " + explain(verdict, counts);
  if (isError(verdict)) {
    ROS_ERROR_STREAM(text);
  } else {
    ROS_WARN_STREAM(text);
  }
}

}  // namespace bs_car_odometry
