#pragma once

#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/core/vehicle.hpp"
#include "bs_car_odometry/core/wheels_and_axles.hpp"

namespace bs_car_odometry {

/// Everything the odometry is built from.
struct OdometryConfiguration {
  Vehicle vehicle;
  NoiseModel noise;
  OdometryOptions options;
  InputLimits limits;
  InitialPose initial_pose;
};

/// Which axles' steering angles a configuration cannot do without.
PerAxle<bool> steeringNeeded(const Vehicle& vehicle, const OdometryOptions& options);

/// The wheels that a configuration reads: those of the selected axles that have an encoder.
PerWheel<bool> wheelsUsed(const Vehicle& vehicle, const OdometryOptions& options);

}  // namespace bs_car_odometry
