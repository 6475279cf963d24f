#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/se2.hpp"
#include "bs_car_odometry/core/wheels_and_axles.hpp"

#include <Eigen/Core>

namespace bs_car_odometry {

/// What a steering angle that cannot be trusted does to the pose: the held angle of each axle's sensor is off
/// by an error that stays the same for as long as the doubt lasts, so that its effect adds up over the steps
/// (rows S4, E6 of docs/reliability.md). Carries the sensitivity of the pose to those two errors.
class SteeringDoubt {
 public:
  void reset() { sensitivity_.setZero(); }
  bool isActive() const { return (sensitivity_.array() != 0.0).any(); }

  /// @param J_motion  dt/dA of the step, whose columns of the steering offsets are used
  /// @param sigma     standard deviation of each sensor's error [rad]; 0 where it is trusted
  void advance(const PoseStep& step, const SystematicSensitivity& J_motion, const PerAxle<double>& sigma);

  /// Its share in the covariance of the pose (x, y, yaw).
  Eigen::Matrix3d share() const { return sensitivity_ * sensitivity_.transpose(); }

 private:
  using Columns = Eigen::Matrix<double, 3, 2>;
  Columns sensitivity_{Columns::Zero()};  ///< times the standard deviation
};

}  // namespace bs_car_odometry
