#include "bs_car_odometry/ros/wait_timer.hpp"

#include <algorithm>

namespace bs_car_odometry {

namespace {

constexpr double kLongestWait = 1e6;  // [s], within what a timer takes

}  // namespace

WaitTimer::WaitTimer(const ros::NodeHandle& node, const std::function<void(const ros::Time&)>& look)
    : timer_(node.createTimer(
          ros::Duration(kLongestWait), [look](const ros::TimerEvent&) { look(ros::Time::now()); }, true,
          false)) {}

void WaitTimer::start(const std::optional<ros::Time>& deadline, const ros::Time& now) {
  if (!deadline) return;
  const double wait = *deadline > now ? deadline->toSec() - now.toSec() : 0.0;
  timer_.stop();
  timer_.setPeriod(ros::Duration(std::clamp(wait, 1e-4, kLongestWait)));
  timer_.start();
}

}  // namespace bs_car_odometry
