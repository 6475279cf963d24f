#pragma once

#include "bs_car_odometry/core/axle_odometry.hpp"
#include "bs_car_odometry/core/odometry_configuration.hpp"
#include "bs_car_odometry/core/wheel_fit.hpp"

#include <variant>

namespace bs_car_odometry {

/// From the readings of a step to the motion of the body: all wheels or the two of one axle.
using OdometryModel = std::variant<WheelFit, AxleOdometry>;

OdometryModel makeOdometryModel(const OdometryConfiguration& configuration);

}  // namespace bs_car_odometry
