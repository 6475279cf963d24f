#pragma once

#include "bs_car_odometry/OdometryStatus.h"
#include "bs_car_odometry/SteeringAngle.h"
#include "bs_car_odometry/WheelTicks.h"
#include "bs_car_odometry/core/wheels_and_axles.hpp"
#include "support/invariants.hpp"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Log.h>
#include <tf2_msgs/TFMessage.h>

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry::testing {

using Ticks = std::array<std::int64_t, kWheels>;

/// Calls callbacks until the condition holds.
/// @return false when it does not within the time [s]
bool waitFor(const std::function<bool()>& condition, double seconds = 20.0);

WheelTicks wheelTicks(const Ticks& ticks, const ros::Time& stamp);
SteeringAngle steeringAngle(double angle, const ros::Time& stamp);

/// Drives one odometry as the drivers of a car would and hears everything that it publishes. Every message it
/// hears is held against the invariants.
class OdometryClient {
 public:
  /// @param prefix  namespace of the odometry's topics
  /// @param node    name of the process that must live
  OdometryClient(const std::string& prefix, const std::string& node);

  /// True once the odometry hears the inputs and is heard.
  bool connect();

  void send(const WheelTicks& message) { wheels_.publish(message); }
  void send(const SteeringAngle& message) { steering_.publish(message); }
  void send(const geometry_msgs::PoseWithCovarianceStamped& message) { set_pose_.publish(message); }

  /// Steering and wheels of now, again until odometry and status of their stamp are there.
  std::optional<nav_msgs::Odometry> step(const Ticks& ticks, double angle = 0.0);

  /// Calls ~reset; the next step may jump.
  bool reset();
  void announceJump() { invariants_.announceJump(); }
  /// Somebody publishes on /tf, who is heard.
  bool hearsTransforms() const { return subscribers_.back().getNumPublishers() > 0; }
  /// From now on /tf is not listened to.
  void ignoreTransforms() { subscribers_.pop_back(); }
  /// From now on every step may be of any length.
  void allowJumps() { jumps_allowed_ = true; }
  /// The odometry was started again: nothing that it published before counts.
  void announceNewRun() {
    invariants_.announceNewRun();
    unchecked_.clear();
  }

  /// True when the process is the one it was at the start.
  bool processLives() const { return alive(node_) == process_ && process_ != 0; }

  const std::vector<nav_msgs::Odometry>& odometry() const { return odometry_; }
  const OdometryStatus& status() const { return status_; }
  const std::vector<geometry_msgs::TransformStamped>& transforms() const { return transforms_; }

 private:
  void onOdometry(const nav_msgs::Odometry& message);
  void checkStatuses();

  ros::NodeHandle handle_;
  std::string node_;
  int process_{0};
  Invariants invariants_{InputLimits()};
  bool jumps_allowed_{false};
  std::vector<nav_msgs::Odometry> odometry_;
  OdometryStatus status_;
  std::deque<OdometryStatus> unchecked_;
  std::vector<geometry_msgs::TransformStamped> transforms_;

  ros::Publisher wheels_;
  ros::Publisher steering_;
  ros::Publisher set_pose_;
  ros::ServiceClient reset_;
  std::vector<ros::Subscriber> subscribers_;
};

/// `/diagnostics`, as far as bs_car_odometry writes them.
class DiagnosticsListener {
 public:
  DiagnosticsListener();

  /// True when there was a status of this name and level whose message holds the text.
  bool has(const std::string& name, int level, const std::string& text) const;

  /// Waits for one.
  bool waitForStatus(const std::string& name, int level, const std::string& text);

  /// Times at which reports of the name came.
  std::vector<ros::SteadyTime> timesOf(const std::string& name) const;

 private:
  struct Heard {
    ros::SteadyTime time;
    diagnostic_msgs::DiagnosticStatus status;
  };
  void onDiagnostics(const diagnostic_msgs::DiagnosticArray& message);

  std::vector<Heard> heard_;
  ros::Subscriber subscriber_;
};

/// The log of all nodes.
class LogListener {
 public:
  LogListener();

  /// Lines of at least this level that hold the text so far.
  std::size_t count(const std::string& text, int level) const;
  std::size_t countOf(const std::string& node) const;

  /// Waits for such a line.
  bool waitForLine(const std::string& text, int level, double seconds = 20.0);

  /// True once the log is heard from.
  bool connected() const { return subscriber_.getNumPublishers() > 0; }

 private:
  std::vector<rosgraph_msgs::Log> lines_;
  ros::Subscriber subscriber_;
};

/// What a process holds, from /proc.
struct ProcessSize {
  double resident{0.0};  ///< [MB]
  int threads{0};
  int files{0};
};
ProcessSize sizeOf(int process);

/// main() of a test that is a node.
int runTests(int argc, char** argv, const std::string& name);

}  // namespace bs_car_odometry::testing
