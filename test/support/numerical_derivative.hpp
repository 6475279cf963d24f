#pragma once

#include <Eigen/Core>

namespace bs_car_odometry::test_support {

/// Derivative of f: R^N -> R^M at x by central differences of fourth order,
///     f'(x) = (8 (f(x+h) - f(x-h)) - (f(x+2h) - f(x-2h))) / 12h + O(h^4 f''''').
/// With h = 2e-4 and values of order one: 5e-17 f''''' of truncation and 1e-16/h, some 1e-12, of rounding.
template <int M, int N, typename Function>
Eigen::Matrix<double, M, N> numericalDerivative(const Function& f, const Eigen::Matrix<double, N, 1>& x,
                                                double h = 2e-4) {
  Eigen::Matrix<double, M, N> J;
  for (Eigen::Index i = 0; i < N; ++i) {
    const auto at = [&](double steps) -> Eigen::Matrix<double, M, 1> {
      Eigen::Matrix<double, N, 1> moved = x;
      moved(i) += steps * h;
      return f(moved);
    };
    J.col(i) = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h);
  }
  return J;
}

}  // namespace bs_car_odometry::test_support
