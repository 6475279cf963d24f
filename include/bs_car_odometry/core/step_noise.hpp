#pragma once

#include "bs_car_odometry/core/wheels_and_axles.hpp"

#include <Eigen/Core>

namespace bs_car_odometry {

/// Where the independent noise of a step comes from, source by source (docs/model.md, section 5.1). The
/// errors of the steering angles are not among them: they outlast a step.
struct StepNoise {
  Eigen::Matrix<double, 3, 4> J_motion_wheel{Eigen::Matrix<double, 3, 4>::Zero()};  ///< dt/dS, as kAllWheels
  PerWheel<double> wheel_path;  ///< [m] that a wheel's variance grows with, 0 for wheels not used
  /// dt over the sideways travel of the axles, front and rear.
  Eigen::Matrix<double, 3, 2> J_motion_slip{Eigen::Matrix<double, 3, 2>::Zero()};
  PerAxle<double> axle_path;  ///< [m] that an axle's side slip and the errors of its angle go by
};

}  // namespace bs_car_odometry
