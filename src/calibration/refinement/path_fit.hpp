#pragma once

#include "chain_filter.hpp"
#include "reckoned_path.hpp"

#include <ceres/cost_function.h>

#include <vector>

namespace bs_car_odometry::calibration {

/// Drives as paths, for any values of the parameters.
class ReckonedDrives {
 public:
  /// @param drives, parameters  must outlive it
  /// @param likelihood          fit of the same drives
  ReckonedDrives(const Drives& drives, const Parameters& parameters, const Refinement& likelihood,
                 const ChainOptions& options);

  std::size_t count() const { return drives_.size(); }
  std::size_t lasers(std::size_t drive) const { return trusted_[drive].size(); }
  Chain chain(std::size_t drive, const ParameterVector& values) const;
  std::vector<PathPoint> path(std::size_t drive, const ParameterVector& values) const;

 private:
  const Drives& drives_;
  const Parameters& parameters_;
  ChainOptions options_;
  std::vector<TrustedPoses> trusted_;
  std::vector<Pose2> any_poses_;  ///< dead reckoning needs none
};

/// (C29) Reckoned less measured position at every laser pose of every drive, over the laser's deviations;
/// zero where a pose begins a path, is not believed, or was not reached.
class PathCost final : public ceres::CostFunction {
 public:
  /// @param drives  must outlive it
  /// @param values  of those parameters that are not fitted
  /// @param fitted  numbers of the others, in the order of the unknowns
  PathCost(const ReckonedDrives& drives, const ParameterVector& values, std::vector<Eigen::Index> fitted);

  bool Evaluate(double const* const* unknowns, double* residuals, double** jacobians) const override;

 private:
  const ReckonedDrives& drives_;
  ParameterVector values_;
  std::vector<Eigen::Index> fitted_;
};

/// Least squares of the dead-reckoned paths. Parameters that the likelihood or the fit itself does not
/// observe are kept at their prior.
/// @param likelihood  converged fit of the same drives, where this one begins
Refinement fitPath(const Drives& drives, const Parameters& parameters, const Refinement& likelihood,
                   const ChainOptions& options);

}  // namespace bs_car_odometry::calibration
