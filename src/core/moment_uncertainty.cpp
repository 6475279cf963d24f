#include "bs_car_odometry/core/moment_uncertainty.hpp"

#include "bs_car_odometry/core/nearest_covariance.hpp"

namespace bs_car_odometry {

ExactMoments::ExactMoments(const SystematicPrior& prior, SystematicRule rule) : rule_(rule), nodes_(prior) {
  reset({}, Eigen::Matrix3d::Zero());
}

void ExactMoments::reset(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  noise_.reset(pose, covariance);
  dead_reckoned_ = pose;
  nodes_.reset();
  sensitivity_.setZero();
}

void ExactMoments::advance(const UncertainStep& step) {
  noise_.advance(GaussianStep::ofBody(step.increment.motion, step.increment.path_covariance));
  dead_reckoned_ = step.moved.pose;
  if (rule_ == SystematicRule::kDegreeFive) {
    nodes_.advance(step.moved, step.increment.motion, step.J_motion);
  } else {
    advanceSensitivity(step.moved, step.J_motion, sensitivity_);
  }
}

/// What the old errors did beyond first order is over, as is the lag of the noise: their covariance stays.
void ExactMoments::setSystematic(const SystematicPrior& prior, const SystematicCovariance& carried) {
  Eigen::Matrix3d covariance;
  getTotal(covariance);
  if (rule_ == SystematicRule::kDegreeFive) sensitivity_ = nodes_.sensitivity();
  sensitivity_ = (sensitivity_ * carried).eval();
  covariance -= sensitivity_ * sensitivity_.transpose();
  noise_.reset(dead_reckoned_, withoutNegativeVariances(covariance));
  nodes_ = SystematicNodes(prior);
  nodes_.reset(sensitivity_);
}

/// From the dead-reckoned position to the expected one as the noise has it.
Eigen::Vector2d ExactMoments::noiseLag() const {
  const Pose2 mean = noise_.mean();
  return {mean.x - dead_reckoned_.x, mean.y - dead_reckoned_.y};
}

/// What the noise and what the parameters make of it add up, since each is small against the path.
Eigen::Vector2d ExactMoments::lag() const {
  if (rule_ == SystematicRule::kSensitivity) return noiseLag();
  const std::complex<double> nodes = nodes_.lag();
  return noiseLag() + Eigen::Vector2d(nodes.real(), nodes.imag());
}

Eigen::Matrix3d ExactMoments::central() const {
  Eigen::Matrix3d central = total();
  const Eigen::Vector2d offset = lag();
  central.topLeftCorner<2, 2>() -= offset * offset.transpose();
  return central;
}

/// Weights below zero may leave a negative variance far outside the reach of the rule: then the nearest
/// covariance is published.
void ExactMoments::getTotal(Eigen::Matrix3d& total) const {
  total = noise_.covariance();
  Eigen::Vector2d offset = noiseLag();
  if (rule_ == SystematicRule::kSensitivity) {
    setTotal(noise_.covariance(), sensitivity_, 1.0, total);
  } else {
    const std::complex<double> nodes = nodes_.lag();
    const Eigen::Vector2d other(nodes.real(), nodes.imag());
    total += nodes_.secondMoment();
    total.topLeftCorner<2, 2>() += offset * other.transpose() + other * offset.transpose();
  }
  total.topLeftCorner<2, 2>() += offset * offset.transpose();
  repaired_ = repair(total);
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

void ClosedForm::setSystematic(const SystematicPrior& /*prior*/, const SystematicCovariance& carried) {
  noise_.add(carryOver(carried, sensitivity_));
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

void Paper2Simplified::setSystematic(const SystematicPrior& /*prior*/, const SystematicCovariance& carried) {
  noise_ += carryOver(carried, sensitivity_);
}

}  // namespace bs_car_odometry
