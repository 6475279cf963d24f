#pragma once

#include "bs_car_odometry/core/pose_moments.hpp"
#include "bs_car_odometry/core/pose_uncertainty.hpp"
#include "bs_car_odometry/core/systematic_nodes.hpp"

namespace bs_car_odometry {

/// Exact moments of the pose under the noise of the readings (docs/model.md, S4'), with the constant errors
/// of the parameters by a rule over p(A) (S5) or by their sensitivity Phi. What is published is the second
/// moment of the dead-reckoned pose's error, whose mean is not zero; about that mean it would be smaller.
class ExactMoments final : public PoseUncertainty {
 public:
  ExactMoments(const SystematicPrior& prior, SystematicRule rule);

  void reset(const Pose2& pose, const Eigen::Matrix3d& covariance) override;
  void advance(const UncertainStep& step) override;
  void inflate(const Eigen::Matrix3d& covariance) override { noise_.add(covariance); }
  void setSystematic(const SystematicPrior& prior, const SystematicCovariance& carried) override;
  void getTotal(Eigen::Matrix3d& total) const override;
  bool repaired() const override { return repaired_; }

  /// Covariance about the expected pose.
  Eigen::Matrix3d central() const;

  const PoseMoments& noise() const { return noise_; }

 private:
  Eigen::Vector2d noiseLag() const;
  Eigen::Vector2d lag() const;

  PoseMoments noise_;
  Pose2 dead_reckoned_;
  SystematicRule rule_;
  SystematicNodes nodes_;              ///< with the rule of degree five
  SystematicSensitivity sensitivity_;  ///< otherwise
  mutable bool repaired_{false};       ///< of the latest getTotal()
};

/// P2's closed form (1) to (5) with the cross terms that P2 leaves out (docs/model.md, S3), for the body
/// motion of any axle or fit: exact for one step from a Gaussian pose, which every pose is taken for.
class ClosedForm final : public PoseUncertainty {
 public:
  ClosedForm() { reset({}, Eigen::Matrix3d::Zero()); }

  void reset(const Pose2& pose, const Eigen::Matrix3d& covariance) override;
  void advance(const UncertainStep& step) override;
  void inflate(const Eigen::Matrix3d& covariance) override { noise_.add(covariance); }
  void setSystematic(const SystematicPrior& /*prior*/, const SystematicCovariance& carried) override;
  void getTotal(Eigen::Matrix3d& total) const override;

 private:
  PoseMoments noise_;
  SystematicSensitivity sensitivity_;
};

/// P2's closed form as P2 used it, without cross terms: Sigma' = Sigma + G P G^T (docs/model.md, S2). Errors
/// of heading never become errors of position, so it is far too certain; for reproduction only.
class Paper2Simplified final : public PoseUncertainty {
 public:
  Paper2Simplified() { reset({}, Eigen::Matrix3d::Zero()); }

  void reset(const Pose2& pose, const Eigen::Matrix3d& covariance) override;
  void advance(const UncertainStep& step) override;
  void inflate(const Eigen::Matrix3d& covariance) override { noise_ += covariance; }
  void setSystematic(const SystematicPrior& /*prior*/, const SystematicCovariance& carried) override;
  void getTotal(Eigen::Matrix3d& total) const override { setTotal(noise_, sensitivity_, 1.0, total); }

 private:
  Eigen::Matrix3d noise_;
  SystematicSensitivity sensitivity_;
};

}  // namespace bs_car_odometry
