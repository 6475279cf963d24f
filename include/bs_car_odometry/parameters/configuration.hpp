#pragma once

#include "bs_car_odometry/core/odometry_configuration.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"

namespace bs_car_odometry {

/// Wheel joints become counters of 2^-32 rad, finer than any encoder, so that one code handles both.
constexpr double kTicksPerRadian = 4294967296.0;

/// What an odometry with these parameters is built from.
OdometryConfiguration toConfiguration(const Parameters& parameters);

}  // namespace bs_car_odometry
