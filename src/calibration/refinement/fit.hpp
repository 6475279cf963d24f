#pragma once

#include "chain.hpp"
#include "chain_filter.hpp"

#include <ceres/types.h>

#include <vector>

namespace bs_car_odometry::calibration {

/// What a motion far beyond its noise costs. Far from the solution a loss that forgives has no slope, or
/// leads to a place where motion is forgiven that was right: it comes in steps.
enum class SlipPolicy { kNone, kSoft, kForgiven };

/// Gains and scales stay within [kLeastGain, kLargestGain].
inline bool hasBounds(std::size_t parameter) {
  return isGain(parameter) || parameter == kFrontScale || parameter == kRearScale;
}

/// A refinement while it is being worked out: chains about the present values, solved and made anew in turn.
class Fit {
 public:
  /// @param drives, parameters  must outlive the fit
  Fit(const Drives& drives, const Parameters& parameters, const RefinementOptions& options);

  void run();

  const ParameterPrior& prior() const { return prior_; }
  const ParameterVector& values() const { return values_; }
  bool converged() const { return converged_; }
  const ChainOptions& chainOptions() const { return chain_options_; }
  Refinement result() const;

  /// The drives about the fit, each link with the share of the wheels' noise in it.
  std::vector<Chain> chainsWithWheelNoise() const;

 private:
  bool makeChains();
  ceres::TerminationType solve();
  void adopt(const ParameterVector& values);
  void setWeights(Chain& chain) const;
  void updateCovariance();
  double movedBy(const ParameterVector& before) const;
  bool hasSlips() const;
  ParameterMask atBound() const;

  const Drives& drives_;
  const Parameters& parameters_;
  ParameterPrior prior_;
  ChainOptions chain_options_;
  std::vector<std::vector<Pose2>> poses_;  ///< base_link at each laser pose of each drive
  std::vector<Chain> chains_;
  ParameterVector values_;
  ParameterMatrix covariance_{ParameterMatrix::Zero()};
  SlipPolicy slips_{SlipPolicy::kNone};
  double cost_{0.0};
  int rounds_{0};
  int iterations_{0};
  bool converged_{false};
};

}  // namespace bs_car_odometry::calibration
