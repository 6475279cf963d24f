#pragma once

#include "chain.hpp"

#include <Eigen/Core>

#include <vector>

namespace bs_car_odometry::calibration {

/// The parameters of a fit and what is believed of them before the drives.
struct ParameterPrior {
  explicit ParameterPrior(const Parameters& parameters);

  ParameterMask estimated;
  std::vector<Eigen::Index> active;  ///< numbers of those that are estimated
  ParameterVector mean;
  ParameterVector deviation;  ///< zero for what is not estimated
};

/// Standard deviations over those that a chain was made with.
struct NoiseScales {
  double wheel{1.0};
  LaserScales laser;
};

/// A laser pose against what all poses before it let expect.
struct ChainInnovation {
  Eigen::Vector3d residual;
  Eigen::Matrix3d covariance;  ///< S
};

/// Kalman filter of the errors of a fit, linear about it: eliminates pose after pose, so that the information
/// of the drives on the parameters remains (docs/calibration.md, C23). As many operations as there are poses.
class ChainFilter {
 public:
  /// @param values  of the fit that the chains come from
  ChainFilter(const ParameterPrior& prior, const ParameterVector& values);

  /// Adds the information of a drive. A chain's first pose, and every pose that is not linked, is unknown.
  /// @param innovations  those of every laser pose with a weight, but for the first ones; may be null
  void add(const Chain& chain, const NoiseScales& scales = {},
           std::vector<ChainInnovation>* innovations = nullptr);

  /// What the values lack, with the information so far; next to zero after a fit of the same drives.
  ParameterVector correction() const;
  /// Zero for what is not estimated.
  ParameterMatrix covariance() const;

 private:
  static constexpr int kMostStates = 3 + static_cast<int>(kCount);
  using StateMatrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostStates, kMostStates>;
  using StateVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostStates, 1>;
  using Rows = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMostStates>;

  void takeEvidence(const Evidence& evidence);
  Rows motionJacobian(const Node& from, const Node& to) const;
  Rows laserJacobian(const Node& node) const;
  void move(const Node& from, const Node& to, double wheel_scale);
  void begin(const Node& node, const Eigen::Matrix3d& R);
  ChainInnovation correct(const Node& node, const Eigen::Matrix3d& R);

  const ParameterPrior& prior_;
  ParameterVector values_;
  Eigen::Index n_;  ///< states: pose and estimated parameters
  StateVector x_;   ///< errors of the fit
  StateMatrix P_;
};

}  // namespace bs_car_odometry::calibration
