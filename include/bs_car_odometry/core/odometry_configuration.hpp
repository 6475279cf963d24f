#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/core/time.hpp"
#include "bs_car_odometry/core/vehicle.hpp"
#include "bs_car_odometry/core/wheels_and_axles.hpp"

#include <optional>

namespace bs_car_odometry {

/// Everything the odometry is built from.
struct OdometryConfiguration {
  Vehicle vehicle;
  NoiseModel noise;
  OdometryOptions options;
  InputLimits limits;
  InitialPose initial_pose;
  RelativeMotionOptions relative_motion;
  std::optional<SystematicCovariance> systematic_covariance{};  ///< a calibration's, for noise.systematic
};

/// What a calibration gives the odometry.
struct OdometryCalibration {
  PerAxle<AxleGains> gains;
  PerAxle<SteeringCalibration> steering;
  SystematicCovariance covariance;  ///< Sigma_A
};

/// Which axles' steering angles a configuration cannot do without.
PerAxle<bool> steeringNeeded(const Vehicle& vehicle, const OdometryOptions& options);

/// The wheels that a configuration reads: those of the selected axles that have an encoder.
PerWheel<bool> wheelsUsed(const Vehicle& vehicle, const OdometryOptions& options);

/// Stamps jitter: an interval between them may be shorter than the car moved, by so much.
constexpr Duration kStampJitter = std::chrono::milliseconds(10);

/// How far anything of a car can have come between two stamps [m]; what is further is implausible (E3 of
/// docs/reliability.md).
double longestStep(const InputLimits& limits, Duration interval);

/// (x, y, yaw) variances of motion that was not seen during `interval`, at up to max_speed [m^2, m^2, rad^2].
Eigen::Vector3d unseenMotion(const OdometryConfiguration& configuration, Duration interval);

}  // namespace bs_car_odometry
