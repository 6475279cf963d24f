#pragma once

#include "bs_car_odometry/OdometryStatus.h"
#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/core/se2.hpp"
#include "bs_car_odometry/core/time.hpp"

#include <geometry_msgs/PoseArray.h>
#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/Quaternion.h>
#include <geometry_msgs/TransformStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/time.h>

#include <boost/array.hpp>
#include <optional>
#include <string>

namespace bs_car_odometry {

/// Stamp of a message as the core's time; none when its nanoseconds are out of range. Never throws, whatever
/// a message carries.
std::optional<Time> toTime(const ros::Time& stamp);

/// Nearest `ros::Time`; times before the epoch become its beginning, times after its range its end.
ros::Time toRos(Time time);

/// Rotation about z [rad].
geometry_msgs::Quaternion toQuaternion(double yaw);

/// A message's quaternion with a norm of 0.9 to 1.1 as yaw [rad]; none otherwise.
std::optional<double> toYaw(const geometry_msgs::Quaternion& quaternion);

/// (x, y, yaw) covariance as the 6x6 one of a message, row by row; z, roll and pitch get
/// `unmeasured_variance`.
boost::array<double, 36> toCovariance(const Eigen::Matrix3d& covariance, double unmeasured_variance);

/// The (x, y, yaw) part of a message's covariance, symmetrised.
Eigen::Matrix3d toPlanarCovariance(const boost::array<double, 36>& covariance);

/// Finite, and no eigenvalue below -1e-9 of the largest.
bool isCovariance(const Eigen::Matrix3d& matrix);

/// Pose of a message as a planar pose; none when it is not finite or its quaternion is none.
std::optional<Pose2> toPose(const geometry_msgs::Pose& pose);

/// What every published message carries besides the estimate.
struct OutputFrames {
  std::string odom;
  std::string base;
  double unmeasured_variance{0.0};
};

/// Fill a message with an update; the message may be reused.
void fillOdometry(const OdometryUpdate& update, const OutputFrames& frames, nav_msgs::Odometry& message);
void fillTransform(const OdometryUpdate& update, const OutputFrames& frames,
                   geometry_msgs::TransformStamped& message);
void fillStatus(const OdometryUpdate& update, const OutputFrames& frames, OdometryStatus& message);

/// Particles for display, evenly out of all of them.
void fillParticles(const OdometryUpdate& update, const PoseUncertainty& uncertainty,
                   const OutputFrames& frames, std::size_t most, geometry_msgs::PoseArray& message);

}  // namespace bs_car_odometry
