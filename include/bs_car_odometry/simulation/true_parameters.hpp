#pragma once

#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/core/vehicle.hpp"

#include <cstdint>

namespace bs_car_odometry::simulation {

/// What the simulated car is in truth, where its odometry has only the configured values:
/// travel of a wheel = k * metres_per_tick * ticks, track = k_b * B, angle = scale * reading + offset.
struct TrueParameters {
  PerAxle<AxleGains> gains;
  PerAxle<SteeringCalibration> steering;
};

/// The configuration is the truth.
TrueParameters asConfigured(const Vehicle& vehicle);

/// Gains (k_r, k_l, k_b) = (1.02, 0.99, 1.03) times the configured ones, on both axles; steering as
/// configured.
TrueParameters withScenarioGains(const Vehicle& vehicle);

/// One draw from p(A): configured values plus errors of its distributions, each axle with its own; the rear
/// axle's steering offset only where it is measured.
TrueParameters drawnFrom(const SystematicNoise& systematic, const Vehicle& vehicle, std::uint64_t seed);

}  // namespace bs_car_odometry::simulation
