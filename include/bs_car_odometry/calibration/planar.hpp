#pragma once

#include "bs_car_odometry/calibration/calibrated_parameters.hpp"
#include "bs_car_odometry/core/se2.hpp"

#include <Eigen/Core>

#include <cmath>

/// The plane's geometry as filters, fit and bound need it: errors of poses (x, y, yaw) [m, m, rad].
namespace bs_car_odometry::calibration {

/// 3x3: turns an error (x, y, yaw) that is seen from a body at `yaw` into the frame of the body's pose.
inline Eigen::Matrix3d rotation(double yaw) {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  Eigen::Matrix3d R;
  R << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0;
  return R;
}

/// 3x3: derivative of the pose of one point of a body, or of one time, by the pose of another.
/// @param arm  from the pose that is given to the one that follows, in the frame of both [m]
inline Eigen::Matrix3d leverArm(const Eigen::Vector2d& arm) {
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J(0, 2) = -arm.y();
  J(1, 2) = arm.x();
  return J;
}

/// Pose of the laser in base_link.
inline Pose2 mountOf(const ParameterVector& values) {
  return {values[kLaserX], values[kLaserY], values[kLaserYaw]};
}
/// The same, as it is configured.
inline Pose2 mountOf(const LaserMount& laser) { return {laser.x, laser.y, laser.yaw}; }

}  // namespace bs_car_odometry::calibration
