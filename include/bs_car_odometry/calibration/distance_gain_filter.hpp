#pragma once

#include <Eigen/Core>

namespace bs_car_odometry::calibration {

/// Nominal travels of an axle's wheels on the straight run, zeta_r N_r and zeta_l N_l, either way along the
/// path [m].
struct StraightRun {
  double right{0.0};
  double left{0.0};

  /// k_d is the mean of k_r and k_l with this weight on k_r: one half for equal travels.
  double rightShare() const { return right + left > 0.0 ? right / (right + left) : 0.5; }

  /// (C3), P1 (10) corrected: k_l = (k_d (zeta_r N_r + zeta_l N_l) - k_r zeta_r N_r)/(zeta_l N_l). With zeta
  /// in place of zeta N it is P1's own, for a run of equal pulses.
  double leftGain(double k_d, double k_r) const { return (k_d - rightShare() * k_r) / (1.0 - rightShare()); }
  double leftGainByDistanceGain() const { return 1.0 / (1.0 - rightShare()); }         ///< dk_l/dk_d
  double leftGainByRightGain() const { return -rightShare() / (1.0 - rightShare()); }  ///< dk_l/dk_r
};

/// Stage 1 of P1's calibration (docs/calibration.md, 1): Kalman filter of X = (S, k_d), the travelled
/// distance [m] and the distance gain, (C1):
///     S' = S + k_d (zeta_r E_r + zeta_l E_l)/2,   k_d' = k_d,   z = S.
class DistanceGainFilter {
 public:
  /// @param variance  of k_d before the run
  DistanceGainFilter(double k_d, double variance);

  /// A run begins: S = 0.
  /// @param variance  of the place where it begins, along the run [m^2]
  void begin(double variance);

  /// @param travel    (zeta_r E_r + zeta_l E_l)/2, nominal [m], negative in reverse
  /// @param variance  of the true travel [m^2]: c^2 (|S_r| + |S_l|)/4
  void move(double travel, double variance);

  /// Takes a distance from the beginning of the run [m], positive ahead. One that is off by more than three
  /// standard deviations is believed less, as kSoftLimit has it.
  /// @return the weight, 1 for one that is believed
  double update(double distance, double variance);

  double distance() const { return state_(0); }
  double gain() const { return state_(1); }
  double gainVariance() const { return covariance_(1, 1); }
  /// Of (S, k_d).
  const Eigen::Matrix2d& covariance() const { return covariance_; }

 private:
  Eigen::Vector2d state_;
  Eigen::Matrix2d covariance_{Eigen::Matrix2d::Zero()};
};

}  // namespace bs_car_odometry::calibration
