#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace bs_car_odometry::tools {

/// What the gains do to the end of one drive.
struct GainEffect {
  Eigen::MatrixXd sensitivity;  ///< of the end to the gains (m x p), in units of the end's other errors
  Eigen::MatrixXd covariance;   ///< of the gains (p x p)
};

/// Variances of independent gains that stand for a full covariance where only standard deviations can be
/// given, as in `noise/systematic`: those that come nearest, in least squares, to the same covariances at the
/// ends of the drives. The diagonal alone would be far too large, since gains that only a difference of
/// wheels tells apart are strongly correlated.
/// @param keys  for each gain the number of its variance; gains with the same number share one
/// @return one for each key, 0 or more
Eigen::VectorXd independentVariances(const std::vector<GainEffect>& effects,
                                     const std::vector<std::size_t>& keys);

}  // namespace bs_car_odometry::tools
