#pragma once

#include "bs_car_odometry/core/pose_uncertainty.hpp"

namespace bs_car_odometry {

/// Sigma' = F Sigma F^T + G P G^T.
void advanceNoise(const PoseStep& step, const Eigen::Matrix3d& P, Eigen::Matrix3d& noise);

/// Pose covariance to first order (docs/model.md, S1), with the systematic part carried beside it as the
/// sensitivity Phi of the pose to the parameters:
///     Sigma' = F Sigma F^T + G P G^T,   Phi' = F Phi + G dt/da,   Sigma_total = Sigma + Phi Phi^T.
/// Poses are (x, y, yaw) in odom [m, m, rad].
class FirstOrderCovariance final : public PoseUncertainty {
 public:
  explicit FirstOrderCovariance(const Eigen::Matrix3d& initial) { reset(initial); }

  void reset(const Pose2& /*pose*/, const Eigen::Matrix3d& covariance) override { reset(covariance); }
  void advance(const UncertainStep& step) override {
    advance(step.moved, step.increment.path_covariance, step.J_motion);
  }
  void inflate(const Eigen::Matrix3d& covariance) override { noise_ += covariance; }
  void setSystematic(const SystematicPrior& /*prior*/, const SystematicCovariance& carried) override {
    noise_ += carryOver(carried, sensitivity_);
  }
  void getTotal(Eigen::Matrix3d& total) const override { setTotal(noise_, sensitivity_, 1.0, total); }

  /// Starts again from a pose of this covariance that owes nothing to the parameters.
  void reset(const Eigen::Matrix3d& initial);

  /// @param path_covariance  P, of the step's body motion
  /// @param J_motion         dt/da = dt/dA L
  void advance(const PoseStep& step, const Eigen::Matrix3d& path_covariance,
               const SystematicSensitivity& J_motion);

  const Eigen::Matrix3d& noise() const { return noise_; }
  const SystematicSensitivity& sensitivity() const { return sensitivity_; }

 private:
  Eigen::Matrix3d noise_;
  SystematicSensitivity sensitivity_;
};

}  // namespace bs_car_odometry
