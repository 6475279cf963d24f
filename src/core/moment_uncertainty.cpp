#include "bs_car_odometry/core/moment_uncertainty.hpp"

namespace bs_car_odometry {

ExactMoments::ExactMoments(const SystematicPrior& prior, SystematicRule rule) : rule_(rule), nodes_(prior) {
  reset({}, Eigen::Matrix3d::Zero());
}

void ExactMoments::reset(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  noise_.reset(pose, covariance);
  nodes_.reset();
  sensitivity_.setZero();
}

void ExactMoments::advance(const UncertainStep& step) {
  noise_.advance(GaussianStep::ofBody(step.increment.motion, step.increment.path_covariance));
  if (rule_ == SystematicRule::kDegreeFive) {
    nodes_.advance(step.moved, step.increment.motion, step.J_motion);
  } else {
    advanceSensitivity(step.moved, step.J_motion, sensitivity_);
  }
}

void ExactMoments::setSystematic(const SystematicPrior& prior) {
  Eigen::Matrix3d covariance;
  getTotal(covariance);
  noise_.reset(noise_.mean(), covariance);
  nodes_ = SystematicNodes(prior);
  sensitivity_.setZero();
}

void ExactMoments::getTotal(Eigen::Matrix3d& total) const {
  if (rule_ == SystematicRule::kDegreeFive) {
    setTotal(noise_.covariance() + nodes_.curvature(), nodes_.sensitivity(), 1.0, total);
  } else {
    setTotal(noise_.covariance(), sensitivity_, 1.0, total);
  }
}

void ClosedForm::reset(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  noise_.reset(pose, covariance);
  sensitivity_.setZero();
}

void ClosedForm::advance(const UncertainStep& step) {
  noise_.advance(GaussianStep::ofBody(step.increment.motion, step.increment.path_covariance));
  noise_.makeGaussian();
  advanceSensitivity(step.moved, step.J_motion, sensitivity_);
}

void ClosedForm::setSystematic(const SystematicPrior& /*prior*/) {
  Eigen::Matrix3d covariance;
  getTotal(covariance);
  reset(noise_.mean(), covariance);
}

void ClosedForm::getTotal(Eigen::Matrix3d& total) const {
  setTotal(noise_.covariance(), sensitivity_, 1.0, total);
}

void Paper2Simplified::reset(const Pose2& /*pose*/, const Eigen::Matrix3d& covariance) {
  noise_ = 0.5 * (covariance + covariance.transpose());
  sensitivity_.setZero();
}

void Paper2Simplified::advance(const UncertainStep& step) {
  const Eigen::Matrix3d G = step.moved.J_pose_motion();
  const Eigen::Matrix3d added = G * step.increment.path_covariance * G.transpose();
  noise_ += 0.5 * (added + added.transpose());
  advanceSensitivity(step.moved, step.J_motion, sensitivity_);
}

void Paper2Simplified::setSystematic(const SystematicPrior& /*prior*/) { reset({}, total()); }

}  // namespace bs_car_odometry
