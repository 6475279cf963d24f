#pragma once

#include "bs_car_odometry/parameters/parameters.hpp"

namespace bs_car_odometry::calibration {

/// Parameters of the odometry whose steps a calibration takes. Nobody asks it for relative motions or for the
/// covariance; and it leaves no wheel out, since one whose gain is wrong would then never be calibrated.
Parameters odometryForCalibration(Parameters parameters);

}  // namespace bs_car_odometry::calibration
