#pragma once

#include "drive.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace bs_car_odometry::drives {

/// Many noisy drives of one scenario, true gains as configured; every odometry reads the same ones.
struct MonteCarloSettings {
  DriveSettings drive;  ///< its seed is the first one; each drive has the next
  std::size_t drives{0};
  std::vector<OdometryConfiguration> odometries;
};

/// Where one odometry ended, estimate less truth, which itself moves with the side slip.
struct EndErrors {
  std::vector<Eigen::Vector3d> errors;  ///< (x, y, yaw) in odom [m, m, rad]
  std::vector<double> nees;             ///< (N1) of docs/model.md, each with the covariance of its own drive

  Eigen::Vector3d mean() const;
  Eigen::Matrix3d covariance() const;
  double meanNees() const;
};

/// Simulates on every processor; the result does not depend on how many there are.
/// @return one for each odometry
std::vector<EndErrors> simulateDrives(const MonteCarloSettings& settings);

/// Part of a drive, by the numbers of its samples.
struct Interval {
  std::size_t from{0};
  std::size_t to{0};
  std::size_t every{1};  ///< the odometry is given each so many-th sample
};

/// The same of the motion in a part of each drive, in the axes of base_link at its beginning.
/// @return one for each odometry
std::vector<EndErrors> simulateMotions(const MonteCarloSettings& settings, const Interval& interval);

/// (N1): squared error in exponential coordinates, in units of its covariance.
double normalisedError(const OdometryEstimate& estimate, const simulation::Pose& truth);

}  // namespace bs_car_odometry::drives
