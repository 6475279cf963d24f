#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/core/se2.hpp"

namespace bs_car_odometry {

/// p(A) in the form A = L a with independent a of variance 1: Sigma_A = L L^T, L lower triangular.
/// Sensitivities are carried as those to a, so that the share of the parameters is J L (J L)^T: half the work
/// of J Sigma_A J^T, and positive semidefinite whatever the rounding.
class SystematicRoot {
 public:
  /// @param covariance  Sigma_A, positive semidefinite; a variance of zero is a parameter known exactly
  explicit SystematicRoot(const SystematicCovariance& covariance);

  /// J L.
  SystematicSensitivity operator()(const SystematicSensitivity& J) const;

 private:
  using Block = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  Block front_;  ///< blocks of L: parameters of the front axle, then of the rear axle
  Block rear_front_;
  Block rear_;
};

/// total = scale (noise + J J^T): a covariance with the share of the parameters, from the sensitivity J to a.
void setTotal(const Eigen::Matrix3d& noise, const SystematicSensitivity& J, double scale,
              Eigen::Matrix3d& total);

/// Pose covariance to first order (docs/model.md, S1), with the systematic part carried beside it as the
/// sensitivity Phi of the pose to the parameters:
///     Sigma' = F Sigma F^T + G P G^T,   Phi' = F Phi + G dt/da,   Sigma_total = Sigma + Phi Phi^T.
/// Poses are (x, y, yaw) in odom [m, m, rad].
class FirstOrderCovariance {
 public:
  explicit FirstOrderCovariance(const Eigen::Matrix3d& initial) { reset(initial); }

  /// Starts again from a pose of this covariance that owes nothing to the parameters.
  void reset(const Eigen::Matrix3d& initial);

  /// @param path_covariance  P, of the step's body motion
  /// @param J_motion         dt/da = dt/dA L
  void advance(const PoseStep& step, const Eigen::Matrix3d& path_covariance,
               const SystematicSensitivity& J_motion);

  /// Adds the covariance of motion that was not seen.
  void inflate(const Eigen::Matrix3d& covariance) { noise_ += covariance; }

  /// Counts what the parameters have done so far as noise, so that others can take their place.
  void settleSystematic() { reset(total()); }

  Eigen::Matrix3d total() const {
    Eigen::Matrix3d total;
    getTotal(total);
    return total;
  }
  /// The same into a matrix that exists: no copy in every step.
  void getTotal(Eigen::Matrix3d& total) const { setTotal(noise_, sensitivity_, 1.0, total); }
  const Eigen::Matrix3d& noise() const { return noise_; }
  const SystematicSensitivity& sensitivity() const { return sensitivity_; }

 private:
  void addNoise(const PoseStep& step, const Eigen::Matrix3d& P);

  Eigen::Matrix3d noise_;
  SystematicSensitivity sensitivity_;
};

/// p(A) as a covariance: independent parameters, each axle with its own (docs/interface.md).
SystematicCovariance systematicCovariance(const SystematicNoise& noise);

}  // namespace bs_car_odometry
