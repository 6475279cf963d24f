#include "bs_car_odometry/core/nearest_covariance.hpp"

#include <Eigen/Eigenvalues>

namespace bs_car_odometry {

Eigen::Matrix3d withoutNegativeVariances(const Eigen::Matrix3d& covariance) {
  Eigen::Matrix3d symmetric = 0.5 * (covariance + covariance.transpose());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(symmetric);
  if (!(solver.eigenvalues().minCoeff() < 0.0)) return symmetric;
  const Eigen::Matrix3d& V = solver.eigenvectors();
  const Eigen::Matrix3d nearest = V * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * V.transpose();
  return 0.5 * (nearest + nearest.transpose());
}

bool repair(Eigen::Matrix3d& covariance) {
  constexpr double kRounding = 1e-12;  // of the largest eigenvalue, what is published may be negative by
  if (isPositiveDefinite(covariance)) return false;
  const Eigen::Matrix3d before = covariance;
  covariance = withoutNegativeVariances(before);
  return (covariance - before).norm() > kRounding * covariance.norm();
}

}  // namespace bs_car_odometry
