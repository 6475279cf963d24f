#pragma once

#include <ros/node_handle.h>
#include <ros/timer.h>

#include <functional>
#include <optional>

namespace bs_car_odometry {

/// Wheels that wait for steering must be looked at again when their wait ends, even if nothing comes.
class WaitTimer {
 public:
  /// @param look  called with the time when a wait has ended
  WaitTimer(const ros::NodeHandle& node, const std::function<void(const ros::Time&)>& look);

  /// @param deadline  when the wait ends, if there is one
  void start(const std::optional<ros::Time>& deadline, const ros::Time& now);

  /// Afterwards nobody is called any more.
  void stop() { timer_.stop(); }

 private:
  ros::Timer timer_;
};

}  // namespace bs_car_odometry
