#pragma once

#include "bs_car_odometry/CalibrationState.h"
#include "bs_car_odometry/ros/simulated_drive.hpp"
#include "child_process.hpp"
#include "support/invariants.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry::testing {

using LaserMessage = geometry_msgs::PoseWithCovarianceStamped;

/// A calibration_node of its own namespace, driven as by a car and its localiser; what it publishes is held
/// against the invariants.
class CalibrationClient {
 public:
  /// @param name  of the namespace; the node's parameters are those of the template, set() comes on top
  explicit CalibrationClient(const std::string& name);

  template <typename Value>
  void set(const std::string& parameter, const Value& value) {
    ros::param::set(node_ + "/" + parameter, value);
  }
  const std::string& node() const { return node_; }

  /// Starts the node and waits until it is heard and hears.
  bool start();
  ChildProcess& process() { return *process_; }
  void announceNewRun();

  /// Drives so many seconds of a scenario, as fast as the node goes along.
  /// @return false when it does not
  bool drive(SimulatedDrive& drive, double seconds);

  /// From now on the drive's laser poses are those in a map that has moved so.
  void moveMap(const Pose2& moved) { map_ = moved; }

  void send(const LaserMessage& message) { laser_.publish(message); }
  /// Stamp of the newest wheels that were sent.
  const ros::Time& newestWheels() const { return newest_wheels_; }
  /// Newest laser pose of the drive that was sent.
  const LaserMessage& newestLaser() const { return newest_laser_; }

  /// Calls ~start, ~reset or ~save.
  std_srvs::Trigger::Response call(const std::string& service);

  /// The newest; none before the first.
  const std::optional<CalibrationState>& state() const { return state_; }
  const std::vector<nav_msgs::Odometry>& odometry() const { return odometry_; }
  /// True once a state of this stamp or later is there.
  bool waitForState(const ros::Time& stamp);

 private:
  void publish(const SimulatedMessage& message);
  void onState(const CalibrationState& message);

  ros::NodeHandle handle_;
  std::string node_;
  std::unique_ptr<ChildProcess> process_;
  ros::Publisher wheels_;
  ros::Publisher steering_;
  ros::Publisher laser_;
  std::vector<ros::Subscriber> subscribers_;
  Invariants invariants_{InputLimits()};
  std::optional<CalibrationState> state_;
  std::vector<nav_msgs::Odometry> odometry_;
  ros::Time newest_wheels_;
  LaserMessage newest_laser_;
  Pose2 map_;
};

}  // namespace bs_car_odometry::testing
