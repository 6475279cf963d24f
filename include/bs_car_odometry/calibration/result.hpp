#pragma once

#include "bs_car_odometry/calibration/calibrated_parameters.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace bs_car_odometry::calibration {

/// The drives that a calibration comes from.
struct DataUsed {
  std::vector<std::string> bags;  ///< their names; empty for a live calibration
  double from{0.0};               ///< [s] stamps of the first and the last laser pose
  double to{0.0};
  double distance{0.0};  ///< [m]
  std::uint64_t laser_poses{0};
  std::uint64_t rejected{0};
  std::string objective{};  ///< of the fit of all readings; empty: the filter alone. Not read back
};

/// What a calibration has found, and how well.
struct CalibrationResult {
  ParameterVector values{ParameterVector::Zero()};
  ParameterMatrix covariance{ParameterMatrix::Zero()};
  ParameterMask listed{};        ///< observed: these replace what the vehicle's file says
  ParameterMask not_observed{};  ///< estimated, but the drive did not show them
  DataUsed data;
};

}  // namespace bs_car_odometry::calibration
