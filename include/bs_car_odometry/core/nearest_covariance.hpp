#pragma once

#include <Eigen/Core>

namespace bs_car_odometry {

/// True for a symmetric matrix whose eigenvalues are above zero, by its leading minors; false also where a
/// minor is so small a part of the product of its variances that its sign may be rounding.
inline bool isPositiveDefinite(const Eigen::Matrix3d& m) {
  constexpr double kRounding = 1e-13;  // some hundred times what the minors' terms can lose
  const double xx = m(0, 0);
  const double product = xx * m(1, 1);
  const double minor = product - m(0, 1) * m(0, 1);
  const double determinant = minor * m(2, 2) - xx * m(1, 2) * m(1, 2) - m(1, 1) * m(0, 2) * m(0, 2) +
                             2.0 * m(0, 1) * m(0, 2) * m(1, 2);
  return xx > 0.0 && minor > kRounding * product && determinant > kRounding * product * m(2, 2);
}

/// The nearest covariance: symmetric, with eigenvalues below zero put to zero.
Eigen::Matrix3d withoutNegativeVariances(const Eigen::Matrix3d& covariance);

/// Puts the nearest covariance in the place of a matrix.
/// @return true where the matrix was none, by more than rounding
bool repair(Eigen::Matrix3d& covariance);

}  // namespace bs_car_odometry
