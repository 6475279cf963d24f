#pragma once

#include "chain_filter.hpp"

#include <Eigen/Core>

#include <array>
#include <vector>

namespace bs_car_odometry::calibration {

/// The levels that are sought, in this order: wheels, position and yaw of the laser.
constexpr int kLevels = 3;
using LevelVector = Eigen::Matrix<double, kLevels, 1>;
using LevelMask = std::array<bool, kLevels>;

/// Logarithms of the levels over those that the chains were made with, and what is known of them.
struct LevelEstimate {
  LevelVector logs{LevelVector::Zero()};
  LevelVector deviations{LevelVector::Zero()};  ///< zero where not found
  LevelMask found{};
  double outliers{0.0};  ///< share of the laser poses left out
  bool converged{false};
};

/// Maximum of the likelihood of the innovations over the levels (docs/calibration.md, C25 to C28).
/// @param chains  about a fit, with the wheels' share of the noise; their weights are set anew
LevelEstimate fitLevels(std::vector<Chain>& chains, const ParameterPrior& prior,
                        const ParameterVector& values);

}  // namespace bs_car_odometry::calibration
