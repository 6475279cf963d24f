#pragma once

#include "bs_car_odometry/RelativeMotion.h"
#include "bs_car_odometry/parameters/parameters.hpp"
#include "bs_car_odometry/ros/odometry_adapter.hpp"
#include "bs_car_odometry/ros/odometry_diagnostics.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>

#include <array>
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

 private:
  void advertise();
  void subscribe();
  void subscribeSteering(Axle axle);
  void subscribeWheels();
  void subscribeJoints();
  /// What every input message goes through: clock, adapter, log, then whatever has become complete.
  template <typename Add>
  void receive(const char* topic, const Add& add);
  /// Warns of a dropped message, once per cause in a while.
  void warn(const char* topic, Verdict verdict);
  /// Warns of wheels that were dropped when their turn came.
  void warnOfLateDrops();
  void noteClock(const ros::Time& now);
  void publishComplete(const ros::Time& now);
  void publishUpdates(const ros::Time& now);
  void publish(const OdometryUpdate& update);
  void publishParticles(const OdometryUpdate& update);
  void startWaiting(const ros::Time& now);
  void reportCalibrationFile();
  void onCalibration(const CalibrationState& message);
  void onSetPose(const geometry_msgs::PoseWithCovarianceStamped& message);
  bool onRelativeMotion(RelativeMotion::Request& request, RelativeMotion::Response& response);
  bool onReset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  ros::NodeHandle node_;
  ros::NodeHandle private_node_;
  Parameters parameters_;
  std::string calibration_error_;  ///< why calibration_file is not used; what follows is made with its gains
  OdometryAdapter adapter_;
  OdometryDiagnostics diagnostics_;

  std::vector<ros::Subscriber> subscribers_;
  ros::Publisher odom_publisher_;
  ros::Publisher tf_publisher_;
  ros::Publisher status_publisher_;
  ros::Publisher particles_publisher_;  ///< with Uncertainty::kMonteCarlo
  ros::SteadyTime particles_published_;
  ros::ServiceServer reset_server_;
  ros::ServiceServer relative_motion_server_;
  ros::Timer wait_timer_;
  Time newest_receipt_;
  InputCounts known_counts_;  ///< what the log knows of
  bool warned_of_clock_{false};
  std::array<ros::SteadyTime, static_cast<std::size_t>(Verdict::kCount)> warned_;
};

/// The parameters below `private_node`; warnings go to the log.
/// @throws ParameterError
Parameters loadNodeParameters(const ros::NodeHandle& private_node);

}  // namespace bs_car_odometry
