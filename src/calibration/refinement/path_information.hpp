#pragma once

#include "chain_filter.hpp"
#include "reckoned_path.hpp"

#include <Eigen/Core>

#include <vector>

namespace bs_car_odometry::calibration {

/// How much a least-squares fit of dead-reckoned paths rests on each error: normal equations, and the
/// covariance of their right-hand side by the noise model (docs/calibration.md, C30).
class PathInformation {
 public:
  explicit PathInformation(const ParameterPrior& prior);

  void add(const std::vector<PathPoint>& path);
  void add(const Evidence& evidence);

  /// Covariance of all parameters when only some of them are fitted and the others keep their prior.
  ParameterMatrix covariance(const ParameterMask& fitted) const;

 private:
  const ParameterPrior& prior_;
  ParameterMatrix normal_;   ///< J^T R^-1 J, summed
  ParameterMatrix scatter_;  ///< covariance of J^T R^-1 e, summed
};

}  // namespace bs_car_odometry::calibration
