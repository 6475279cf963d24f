#pragma once

#include "bs_car_odometry/CalibrationState.h"
#include "bs_car_odometry/calibration/dead_reckoning.hpp"
#include "bs_car_odometry/calibration/driven_paths.hpp"
#include "bs_car_odometry/ros/calibration_adapter.hpp"
#include "bs_car_odometry/ros/calibration_diagnostics.hpp"
#include "bs_car_odometry/ros/checked_subscription.hpp"
#include "bs_car_odometry/ros/clock_watch.hpp"
#include "bs_car_odometry/ros/log_throttle.hpp"
#include "bs_car_odometry/ros/wait_timer.hpp"

#include <ros/ros.h>
#include <std_srvs/Trigger.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry {

/// Wires the calibration to ROS: subscribes, converts, calls, publishes, saves (docs/calibration.md, 3).
/// Callbacks must come from one thread.
class CalibrationRos {
 public:
  /// Reads every parameter, once. Goes on from a checkpoint where there is one.
  /// @throws ParameterError
  CalibrationRos(const ros::NodeHandle& node, const ros::NodeHandle& private_node);

  /// An orderly end: nothing to go on from.
  void end();

 private:
  void advertise();
  void advertiseServices();
  void subscribe();
  void subscribeSteering(Axle axle);
  void subscribeWheels();
  void subscribeJoints();
  void subscribeLaser();
  void subscribeTransforms();
  /// @param callback  (message, sender); no message for one that was cut
  template <typename Message, typename Callback>
  void subscribeTo(const std::string& topic, const Callback& callback);

  /// What every input message goes through: clock, adapter, log, then whatever has become complete.
  template <typename Add>
  void receive(const Add& add);
  void warn(const char* topic, Verdict verdict);
  void warn(calibration::LaserVerdict verdict, const ros::Time& now);
  void note(const calibration::CalibrationUpdate& update);
  void takeUpdates(const ros::Time& now);
  void takeAndWait(const ros::Time& now);

  std::uint64_t refusedAtTheDoor() const;
  void publishState(const ros::Time& stamp);
  void publishOdometry();
  void publishPaths();

  void resume();
  void keep();
  void beginAnew();
  std::string whyNotSaved() const;
  bool onStart(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool onReset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool onSave(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  ros::NodeHandle node_;
  ros::NodeHandle private_node_;
  CalibrationAdapter adapter_;
  calibration::DeadReckoning reckoning_;
  calibration::DrivenPaths paths_;
  CalibrationDiagnostics diagnostics_;
  ClockWatch clock_;
  WaitTimer wait_timer_;
  CalibrationState state_;  ///< of the latest update, with what does not change

  std::vector<CheckedSubscriber> subscribers_;
  std::vector<ros::ServiceServer> servers_;
  ros::Publisher state_publisher_;
  ros::Publisher odom_publisher_;
  ros::Publisher laser_path_publisher_;
  ros::Publisher before_publisher_;
  ros::Publisher after_publisher_;
  ros::WallTimer path_timer_;
  ros::WallTimer checkpoint_timer_;
  ros::WallTimer cut_timer_;
  std::uint64_t refused_before_{0};  ///< at the door, before the calibration began
  bool paths_changed_{false};
  DropLog drop_log_;
  std::array<LogThrottle, static_cast<std::size_t>(calibration::LaserVerdict::kCount)> laser_log_;
  LogThrottle jump_log_;
  LogThrottle begin_log_;
};

}  // namespace bs_car_odometry
