#include "bs_car_odometry/core/first_order_covariance.hpp"

namespace bs_car_odometry {

void FirstOrderCovariance::reset(const Eigen::Matrix3d& initial) {
  noise_ = 0.5 * (initial + initial.transpose());
  sensitivity_.setZero();
}

void FirstOrderCovariance::advance(const PoseStep& step, const Eigen::Matrix3d& path_covariance,
                                   const SystematicSensitivity& J_motion) {
  advanceNoise(step, path_covariance, noise_);
  advanceSensitivity(step, J_motion, sensitivity_);
}

/// F Sigma F^T + G P G^T, upper triangle first. With F = I + f e3^T, f = (-dy, dx, 0), what F adds to Sigma
/// needs only the heading's column: f h^T + h f^T, h = Sigma e3 + Var(theta) f/2.
void advanceNoise(const PoseStep& step, const Eigen::Matrix3d& P, Eigen::Matrix3d& noise) {
  const Eigen::RowVector3d GP_x = step.r * P.row(0) - step.s * P.row(1) + step.p * P.row(2);
  const Eigen::RowVector3d GP_y = step.s * P.row(0) + step.r * P.row(1) + step.q * P.row(2);
  const double yaw_variance = noise(2, 2);
  const double h_x = noise(0, 2) - 0.5 * yaw_variance * step.dy;
  const double h_y = noise(1, 2) + 0.5 * yaw_variance * step.dx;

  noise(0, 0) += step.r * GP_x.x() - step.s * GP_x.y() + step.p * GP_x.z() - 2.0 * step.dy * h_x;
  noise(0, 1) += step.s * GP_x.x() + step.r * GP_x.y() + step.q * GP_x.z() + step.dx * h_x - step.dy * h_y;
  noise(1, 1) += step.s * GP_y.x() + step.r * GP_y.y() + step.q * GP_y.z() + 2.0 * step.dx * h_y;
  noise(0, 2) += GP_x.z() - step.dy * yaw_variance;
  noise(1, 2) += GP_y.z() + step.dx * yaw_variance;
  noise(2, 2) += P(2, 2);
  noise(1, 0) = noise(0, 1);
  noise(2, 0) = noise(0, 2);
  noise(2, 1) = noise(1, 2);
}

}  // namespace bs_car_odometry
