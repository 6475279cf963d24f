#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <optional>
#include <string>

namespace bs_car_odometry::calibration {

/// Everything that a calibration can find, in the order of every vector and covariance over it. The first
/// ones are those of `systematic::Index`.
enum Index : std::size_t {
  kFrontScale = systematic::kCount,  ///< front/steering_scale
  kRearScale,
  kLaserX,      ///< laser/x [m]
  kLaserY,      ///< laser/y [m]
  kLaserYaw,    ///< laser/yaw [rad]
  kTimeOffset,  ///< laser/time_offset [s]
  kCount
};

/// Those that move the car: gains, steering offsets and scales.
constexpr std::size_t kMotionCount = kLaserX;

using ParameterVector = Eigen::Matrix<double, kCount, 1>;
using ParameterMatrix = Eigen::Matrix<double, kCount, kCount>;
using ParameterMask = std::array<bool, kCount>;

/// "front/k_r", "rear/steering_offset", "laser/x", ... as in a calibration file.
std::string parameterName(std::size_t parameter);
/// The inverse of parameterName.
std::optional<std::size_t> parameterNamed(const std::string& name);

constexpr bool isGain(std::size_t parameter) {
  return parameter < systematic::kCount && parameter != systematic::kFrontOffset &&
         parameter != systematic::kRearOffset;
}

/// Which parameters a configuration asks for: `calibration/estimate`, of the axles and wheels that it uses.
ParameterMask parametersToEstimate(const Parameters& parameters);

/// The values that a configuration has.
ParameterVector valuesOf(const Parameters& parameters);

/// Puts values in the place of those that a configuration has.
void setValues(const ParameterVector& values, Parameters& parameters);
/// Those of them that a vehicle has: gains and steering.
void setValues(const ParameterVector& values, Vehicle& vehicle);

/// Standard deviations before the drive: `calibration/prior`, and for the laser what a tape measure and a
/// driver's manual leave open. Zero where nothing is estimated.
ParameterVector priorDeviations(const Parameters& parameters);

}  // namespace bs_car_odometry::calibration
