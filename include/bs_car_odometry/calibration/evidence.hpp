#pragma once

#include "bs_car_odometry/calibration/calibrated_parameters.hpp"
#include "bs_car_odometry/core/body_increment.hpp"

#include <Eigen/Core>

namespace bs_car_odometry::calibration {

/// What the wheels of a car and its angles say of the parameters among each other, with no laser: an error dA
/// has the likelihood exp(-dA^T information dA / 2 + gradient^T dA) about the values of the model. All zero
/// with the odometry of one axle, where nothing is left over.
struct Evidence {
  Eigen::Matrix<double, kMotionCount, kMotionCount> information =
      Eigen::Matrix<double, kMotionCount, kMotionCount>::Zero();
  Eigen::Matrix<double, kMotionCount, 1> gradient = Eigen::Matrix<double, kMotionCount, 1>::Zero();
};

}  // namespace bs_car_odometry::calibration
