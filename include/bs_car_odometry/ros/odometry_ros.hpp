#pragma once

#include "bs_car_odometry/RelativeMotion.h"
#include "bs_car_odometry/parameters/parameters.hpp"
#include "bs_car_odometry/ros/checked_subscription.hpp"
#include "bs_car_odometry/ros/clock_watch.hpp"
#include "bs_car_odometry/ros/early_messages.hpp"
#include "bs_car_odometry/ros/log_throttle.hpp"
#include "bs_car_odometry/ros/odometry_adapter.hpp"
#include "bs_car_odometry/ros/odometry_diagnostics.hpp"
#include "bs_car_odometry/ros/wait_timer.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>

#include <string>
#include <vector>

namespace bs_car_odometry {

/// Wires the odometry to ROS: subscribes, converts, calls, publishes. The nodelet and the node are this
/// class. Callbacks must come from one thread, as from the handles that nodelets and nodes are given.
class OdometryRos {
 public:
  /// Reads every parameter and the calibration file, once.
  /// @throws ParameterError, CalibrationFileError
  OdometryRos(const ros::NodeHandle& node, const ros::NodeHandle& private_node);
  ~OdometryRos();
  OdometryRos(const OdometryRos&) = delete;
  OdometryRos& operator=(const OdometryRos&) = delete;

 private:
  void advertise();
  void subscribe();
  void subscribeSteering(Axle axle);
  void subscribeWheels();
  void subscribeJoints();
  void subscribeTransforms();
  /// @param add  (message, now, sender); no message for one that was cut
  template <typename Message, typename Add>
  void subscribeToSensor(const char* topic, const Add& add);
  /// @param take  (message); none for one that was cut
  template <typename Message, typename Take>
  void subscribeTo(const char* topic, const Take& take);
  /// What every input message goes through: clock, adapter, log, then whatever has become complete.
  template <typename Add>
  void receive(const char* topic, const Add& add);
  /// Begins a new run, or a new time, when the clock went back.
  void followClock(const ros::Time& now);
  bool isEarly(const ros::Time& stamp);
  /// Warns of wheels that were dropped when their turn came.
  void warnOfLateDrops();
  void warnOfFaults(const SensorReport& sensors);
  void publishComplete(const ros::Time& now);
  void publishUpdates(const ros::Time& now);
  void publish(const OdometryUpdate& update);
  void publishParticles(const OdometryUpdate& update);
  void reportCalibrationFile();
  void onCalibration(const CalibrationState* message);
  void onSetPose(const geometry_msgs::PoseWithCovarianceStamped* message);
  bool onRelativeMotion(RelativeMotion::Request& request, RelativeMotion::Response& response);
  bool onReset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  ros::NodeHandle node_;
  ros::NodeHandle private_node_;
  Parameters parameters_;
  std::string calibration_error_;  ///< why calibration_file is not used; what follows is made with its gains
  OdometryAdapter adapter_;
  OdometryDiagnostics diagnostics_;
  ClockWatch clock_;
  WaitTimer wait_timer_;
  EarlyMessages early_;

  std::vector<CheckedSubscriber> subscribers_;
  ros::CallbackQueue transforms_queue_;  ///< of the newest on /tf, most of them this node's own
  ros::Subscriber transforms_subscriber_;
  ros::WallTimer watch_timer_;
  ros::Publisher odom_publisher_;
  ros::Publisher tf_publisher_;
  ros::Publisher status_publisher_;
  ros::Publisher particles_publisher_;  ///< with Uncertainty::kMonteCarlo
  ros::SteadyTime particles_published_;
  ros::ServiceServer reset_server_;
  ros::ServiceServer relative_motion_server_;
  InputCounts known_counts_;  ///< what the log knows of
  DropLog drop_log_;
  LogThrottle rival_transform_log_;
  LogThrottle restart_log_;
  LogThrottle state_log_;
  LogThrottle gap_log_;
  LogThrottle fault_log_;
  LogThrottle undetermined_log_;
  std::uint64_t known_exclusions_{0};
  LogThrottle repair_log_;
  LogThrottle pose_set_log_;
  LogThrottle pose_refused_log_;
  LogThrottle calibration_refused_log_;
};

/// The parameters below `private_node`; warnings go to the log.
/// @throws ParameterError
Parameters loadNodeParameters(const ros::NodeHandle& private_node);

}  // namespace bs_car_odometry
