#pragma once

#include <Eigen/Core>

#include <functional>

namespace bs_car_odometry::tools {

/// Variances of largest likelihood.
struct VarianceFit {
  Eigen::VectorXd variances;  ///< 0 where the likelihood is no larger above
  /// Standard deviations of the *roots* of the variances, from the curvature of the likelihood; 0 where the
  /// root is 0.
  Eigen::VectorXd std_of_roots;
  double log_likelihood{0.0};
};

/// Newton's method in the logarithms, with differences for derivatives: for a few variances only. Where the
/// likelihood rises towards zero the variance is left out, and the others are sought again.
/// @param log_likelihood  of the variances (0 allowed), smooth
/// @param start           above 0, within some orders of magnitude of what is sought
/// @throws std::runtime_error when the likelihood is not finite at the start, or no maximum is found
VarianceFit fitVariances(const std::function<double(const Eigen::VectorXd&)>& log_likelihood,
                         const Eigen::VectorXd& start);

}  // namespace bs_car_odometry::tools
