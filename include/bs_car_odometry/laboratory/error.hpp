#pragma once

#include "bs_car_odometry/core/odometry_estimator.hpp"
#include "bs_car_odometry/simulation/true_body.hpp"

namespace bs_car_odometry::laboratory {

/// Estimate less truth in odom: (x, y, yaw) [m, m, rad], yaw in [-pi, pi].
Eigen::Vector3d poseError(const OdometryEstimate& estimate, const simulation::Pose& truth);

/// Squared Mahalanobis distance e^T covariance^-1 e: chi-square with 3 degrees of freedom for a true
/// Gaussian. Infinite where an error meets no uncertainty.
double normalisedSquare(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance);

/// (N1) of docs/model.md: NEES of the pose in exponential coordinates of SE(2) at the estimate.
double exponentialNees(const Pose2& estimate, const Eigen::Matrix3d& covariance, const Pose2& truth);
double exponentialNees(const OdometryEstimate& estimate, const simulation::Pose& truth);

/// NEES of the pose in (x, y, yaw).
double plainNees(const OdometryEstimate& estimate, const simulation::Pose& truth);

/// The twist that takes one pose to the other in `interval` [s] when it is constant: the truth for a twist
/// that is an increment of the body over its duration, (M-exp). Turns of less than a whole one.
Eigen::Vector3d meanTwist(const simulation::Pose& from, const simulation::Pose& to, double interval);

}  // namespace bs_car_odometry::laboratory
