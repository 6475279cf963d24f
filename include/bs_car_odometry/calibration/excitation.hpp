#pragma once

#include "bs_car_odometry/calibration/calibrated_parameters.hpp"
#include "bs_car_odometry/core/se2.hpp"

#include <string>
#include <vector>

namespace bs_car_odometry::calibration {

/// What the car has done so far, as far as the parameters show by it.
struct Excitation {
  double distance{0.0};      ///< [m], both ways
  double straight{0.0};      ///< [m] of it with less than 0.02 rad of turn a metre
  double turned_left{0.0};   ///< [rad], the sum of turns to the left
  double turned_right{0.0};  ///< [rad]

  void add(const BodyMotion& motion);
};

}  // namespace bs_car_odometry::calibration
