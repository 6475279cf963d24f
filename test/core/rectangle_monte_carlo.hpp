#pragma once

#include "paper2_rectangle.hpp"
#include "support/seeded_generator.hpp"

#include <Eigen/Core>

#include <cmath>
#include <vector>

namespace bs_car_odometry::test_support {

/// Variances of the position after every step of the rectangle [m^2].
struct PositionVariances {
  std::vector<double> x, y;

  void add(double var_x, double var_y) {
    x.push_back(var_x);
    y.push_back(var_y);
  }
  double xAfter(std::size_t step) const { return x[step - 1]; }
  double yAfter(std::size_t step) const { return y[step - 1]; }
};

/// Those of one method of the package.
inline PositionVariances variancesOf(PoseUncertainty& method, double sigma) {
  PositionVariances variances;
  driveRectangle(method, sigma, [&variances](std::size_t /*step*/, const Eigen::Matrix3d& covariance) {
    variances.add(covariance(0, 0), covariance(1, 1));
  });
  return variances;
}

inline double variance(const Eigen::ArrayXd& values) {
  return (values - values.mean()).square().sum() / static_cast<double>(values.size() - 1);
}

/// Those of `runs` robots whose wheels err by `sigma` [m] in every step: the judge, without linearisation and
/// without the package's code.
inline PositionVariances simulatedVariances(double sigma, Eigen::Index runs, unsigned seed) {
  SeededGenerator generator(seed);
  Eigen::ArrayXd x = Eigen::ArrayXd::Zero(runs);
  Eigen::ArrayXd y = x;
  Eigen::ArrayXd heading = x;
  PositionVariances variances;
  for (const WheelTravels& wheels : rectangle()) {
    for (Eigen::Index i = 0; i < runs; ++i) {
      const double right = wheels.right + generator.normal(sigma * sigma);
      const double left = wheels.left + generator.normal(sigma * sigma);
      const double turn = (right - left) / kPaper2Track;
      x(i) += 0.5 * (right + left) * std::cos(heading(i) + 0.5 * turn);
      y(i) += 0.5 * (right + left) * std::sin(heading(i) + 0.5 * turn);
      heading(i) += turn;
    }
    variances.add(variance(x), variance(y));
  }
  return variances;
}

/// Largest fall of a variance below an earlier value of itself, as a share of that value.
inline double largestFall(const std::vector<double>& variances) {
  double highest = 0.0;
  double fall = 0.0;
  for (const double value : variances) {
    highest = std::max(highest, value);
    if (highest > 0.0) fall = std::max(fall, 1.0 - value / highest);
  }
  return fall;
}

}  // namespace bs_car_odometry::test_support
