#pragma once

#include "bs_car_odometry/OdometryStatus.h"
#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/core/time.hpp"

#include <nav_msgs/Odometry.h>
#include <ros/time.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry::testing {

/// What must always be true of what the odometry publishes, whatever arrives (docs/reliability.md, invariants
/// 1 to 4 and 6; the fifth, that the process lives, is alive()). Give it every message in the order of
/// publishing:
///     EXPECT_EQ(invariants.violation(message, ros::Time::now()), "");
class Invariants {
 public:
  explicit Invariants(const InputLimits& limits) : limits_(limits) {}

  /// What the message violates, seen at `now`; empty when it is good.
  std::string violation(const nav_msgs::Odometry& message, const ros::Time& now);

  /// A degraded step must give its reason, and its twist or pose must be as uncertain as that demands: the
  /// pose by the motion that was not seen, at max_speed. To be asked after the odometry of the same stamp.
  std::string violation(const OdometryStatus& message);

  /// The next step may be of any length: ~reset or set_pose.
  void announceJump() { previous_.reset(); }
  /// The clock went back: stamps may begin anew.
  void announceNewRun();

 private:
  std::string stampViolation(Time stamp, Time now);
  std::string stepViolation(const nav_msgs::Odometry& message, Time stamp);
  bool growsByUnseenMotion(const nav_msgs::Odometry& odom, const OdometryStatus& message) const;

  struct Waiting {
    nav_msgs::Odometry message;
    bool jumped;  ///< after it was said that it might
  };

  InputLimits limits_;
  std::optional<nav_msgs::Odometry> previous_;
  std::optional<Time> newest_;
  std::map<Time, Waiting> recent_;  ///< whose status has not been seen yet
  std::optional<OdometryStatus> previous_status_;
  double previous_variance_{0.0};
};

/// Invariant 5: process id of a node that answers; 0 when it does not. The same id as before is the same
/// process.
int alive(const std::string& node);

}  // namespace bs_car_odometry::testing
