#include "bs_car_odometry/core/moment_uncertainty.hpp"

#include "bs_car_odometry/core/nearest_covariance.hpp"

namespace bs_car_odometry {

ExactMoments::ExactMoments(const SystematicPrior& prior, SystematicRule rule) : rule_(rule), nodes_(prior) {
  reset({}, Eigen::Matrix3d::Zero());
}

void ExactMoments::reset(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  noise_.reset(pose, covariance);
  dead_reckoned_ = pose;
  nodes_.reset(covariance);
  sensitivity_.setZero();
}

void ExactMoments::advance(const UncertainStep& step) {
  noise_.advance(GaussianStep::ofBody(step.increment.motion, step.increment.path_covariance));
  dead_reckoned_ = step.moved.pose;
  if (rule_ == SystematicRule::kDegreeFive) {
    nodes_.advance(step.moved, step.increment, step.J_motion);
  } else {
    advanceSensitivity(step.moved, step.J_motion, sensitivity_);
  }
}

void ExactMoments::inflate(const Eigen::Matrix3d& covariance) {
  noise_.add(covariance);
  nodes_.inflate(covariance);
}

void ExactMoments::setSystematic(const SystematicPrior& prior) {
  Eigen::Matrix3d covariance;
  getTotal(covariance);
  noise_.reset(dead_reckoned_, covariance);
  nodes_ = SystematicNodes(prior);
  nodes_.reset(covariance);
  sensitivity_.setZero();
}

/// From the dead-reckoned position to the expected one: what the noise and what the parameters make of it add
/// up, since each is small against the path.
Eigen::Vector2d ExactMoments::lag() const {
  const Pose2 mean = noise_.mean();
  const std::complex<double> nodes = rule_ == SystematicRule::kDegreeFive ? nodes_.lag() : 0.0;
  return {mean.x - dead_reckoned_.x + nodes.real(), mean.y - dead_reckoned_.y + nodes.imag()};
}

Pose2 ExactMoments::expectedPose() const {
  const Eigen::Vector2d position = dead_reckoned_.position() + lag();
  return {position.x(), position.y(), dead_reckoned_.yaw};
}

Eigen::Matrix3d ExactMoments::central() const {
  Eigen::Matrix3d total;
  if (rule_ == SystematicRule::kSensitivity) {
    setTotal(noise_.covariance(), sensitivity_, 1.0, total);
    return total;
  }
  setTotal(noise_.covariance() + nodes_.beyondLinear(), nodes_.sensitivity(), 1.0, total);
  return isPositiveDefinite(total) ? total : withoutNegativeVariances(total);
}

void ExactMoments::getTotal(Eigen::Matrix3d& total) const {
  const Eigen::Vector2d offset = lag();
  total = central();
  total.topLeftCorner<2, 2>() += offset * offset.transpose();
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
