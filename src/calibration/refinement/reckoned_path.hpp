#pragma once

#include "chain.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace bs_car_odometry::calibration {

/// Which laser poses of a drive are believed, by their numbers.
using TrustedPoses = std::vector<bool>;

/// All but those that both the filter and a fit of all readings reject: an outlier stands out whatever is
/// assumed of the motion, and drift does not.
/// @param residuals  of the fit
TrustedPoses trustedPoses(const CalibrationDrive& drive, const std::vector<LaserResidual>& residuals);

/// Dead reckoning at one laser pose, begun at an earlier one that is taken as exact (docs/calibration.md,
/// C29).
struct PathPoint {
  std::size_t laser;                   ///< its number in the drive
  bool begins;                         ///< dead reckoning starts here, at the measured pose
  bool trusted;                        ///< the laser pose is believed
  Pose2 base;                          ///< base_link in the map
  Eigen::Vector2d reckoned;            ///< the laser's point in the map [m]
  Eigen::Vector2d measured;            ///< the same by the laser [m]
  Eigen::Matrix<double, 2, kCount> J;  ///< d reckoned / d parameters
  Eigen::Matrix3d R;                   ///< covariance of the laser pose
  Eigen::Matrix3d noise;               ///< of the motion since the point before, in the map's axes
};

/// Every part of a drive begins at its first trusted pose.
/// @param chain  made with `values`
std::vector<PathPoint> reckonPath(const Chain& chain, const ParameterVector& values,
                                  const TrustedPoses& trusted);

}  // namespace bs_car_odometry::calibration
