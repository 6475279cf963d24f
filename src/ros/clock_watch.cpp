#include "bs_car_odometry/ros/clock_watch.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <ros/console.h>

namespace bs_car_odometry {

bool ClockWatch::runs(const ros::Time& now) {
  if (!now.isZero()) return true;
  if (not_running_.isDue()) ROS_WARN("waiting for /clock: use_sim_time is set, and nothing publishes it");
  return false;
}

/// Differences in 64 bits, since those of ros::Time throw beyond 68 years, which a clock that somebody else
/// publishes may jump.
bool ClockWatch::wentBack(const ros::Time& now) {
  const Time time = toTime(now).value_or(newest_);
  const Duration step_back = newest_ - time;
  const bool went_back = step_back > max_future_;
  if (went_back && went_back_.isDue())
    ROS_WARN("the clock went back by %.3f s: %s", toSeconds(step_back),
             ros::Time::isSimTime() ? "a new run begins" : "the pose is kept");
  if (went_back || newest_ < time) newest_ = time;
  return went_back;
}

}  // namespace bs_car_odometry
