#include "bs_car_odometry/calibration/dead_reckoning.hpp"

#include "bs_car_odometry/calibration/planar.hpp"
#include "bs_car_odometry/parameters/configuration.hpp"

#include <Eigen/Cholesky>

namespace bs_car_odometry::calibration {

namespace {

/// So many steps wait for a first fix: 80 s at 100 Hz.
constexpr std::size_t kMostWaiting = 8192;

using MotionMatrix = Eigen::Matrix<double, kMotionCount, kMotionCount>;

/// L with L L^T = the covariance of the parameters that move the car; rows of those that are known are zero.
MotionMatrix rootOf(const ParameterMatrix& covariance) {
  const MotionMatrix P = covariance.topLeftCorner<kMotionCount, kMotionCount>();
  const Eigen::LDLT<MotionMatrix> factors(P);
  MotionMatrix root =
      MotionMatrix(factors.matrixL()) * factors.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  return factors.transpositionsP().transpose() * root;
}

}  // namespace

DeadReckoning::DeadReckoning(const Parameters& parameters)
    : configuration_(toConfiguration(parameters)),
      model_(parameters),
      root_(priorDeviations(parameters).head<kMotionCount>().asDiagonal()) {}

void DeadReckoning::start() {
  begun_ = false;
  waiting_.clear();
  newest_.reset();
}

void DeadReckoning::add(const OdometryUpdate& update) {
  const bool seen = update.step && (!newest_ || update.step->span.begin == *newest_);
  if (!seen) start();
  newest_ = update.stamp;
  if (!update.step) return;
  waiting_.push_back({update, *update.step});
  if (waiting_.size() > kMostWaiting) waiting_.pop_front();
}

bool DeadReckoning::correct(const CalibrationUpdate& update) {
  const bool begins = !begun_;
  model_.setValues(update.estimate.values);
  root_ = rootOf(update.estimate.covariance);
  if (begins) begin(update);
  return begins;
}

void DeadReckoning::begin(const CalibrationUpdate& update) {
  while (!waiting_.empty() && waiting_.front().step.span.end <= update.seen) waiting_.pop_front();
  if (!waiting_.empty() && waiting_.front().step.span.begin < update.seen)
    waiting_.front().step = split(waiting_.front().step, update.seen).second;
  pose_ = update.estimate.pose;
  noise_ = update.estimate.pose_covariance;
  sensitivity_.setZero();
  begun_ = true;
}

std::optional<DeadReckonedPose> DeadReckoning::next() {
  if (!begun_ || waiting_.empty()) return std::nullopt;
  const OdometryUpdate& update = waiting_.front().update;
  DeadReckonedPose result;
  result.stamp = update.stamp;
  result.twist_covariance = update.estimate.twist_covariance;
  result.twist = update.estimate.twist;
  const MeasuredStep& step = waiting_.front().step;
  MotionSegment segment;
  model_.extend(step, segment);
  if (isPlausible(step.span, segment)) {
    if (update.report.interval > 0.0 && !update.estimate.twist.isZero(0.0)) result.twist = segment.twist;
    move(segment);
  } else {
    stayUnseen(step.span);
  }
  result.pose = pose_;
  const Eigen::Matrix3d covariance = noise_ + sensitivity_ * sensitivity_.transpose();
  result.covariance = 0.5 * (covariance + covariance.transpose());
  result.step = waiting_.front().step;
  waiting_.pop_front();
  return result;
}

/// Wheels and angles that contradict each other can fit, with these parameters, to a motion that is longer
/// than any that the odometry has let pass.
bool DeadReckoning::isPlausible(const TimeSpan& span, const MotionSegment& segment) const {
  return segment.motion.position().norm() <= longestStep(configuration_.limits, span.end - span.begin);
}

/// The pose stays, and may be anywhere around.
void DeadReckoning::stayUnseen(const TimeSpan& span) {
  noise_.diagonal() += unseenMotion(configuration_, span.end - span.begin + kStampJitter);
}

void DeadReckoning::move(const MotionSegment& segment) {
  const Pose2 before = pose_;
  pose_ = before * segment.motion;
  const Eigen::Matrix3d F = leverArm(pose_.position() - before.position());
  const Eigen::Matrix3d R = rotation(before.yaw);
  noise_ = F * noise_ * F.transpose() + R * segment.covariance() * R.transpose();
  sensitivity_ = F * sensitivity_ + R * segment.J * root_;
}

}  // namespace bs_car_odometry::calibration
