#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/vehicle.hpp"

#include <array>
#include <cstddef>

namespace bs_car_odometry::benchmarks {

constexpr std::size_t kSteps = 64;  ///< a power of two
constexpr double kMetresPerTick = 1e-4;

/// The Cycab of the papers, every wheel with an encoder.
Vehicle cycab();

/// One period of a slalom at 1 m/s and 50 Hz; returns to its first heading, so that it can be repeated for
/// ever. Both contenders drive it.
std::array<StepReadings, kSteps> slalom();

}  // namespace bs_car_odometry::benchmarks
