#include "bs_car_odometry/calibration/motion_model.hpp"

#include "bs_car_odometry/core/first_order_covariance.hpp"
#include "bs_car_odometry/parameters/configuration.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::calibration {

namespace {

/// 0.1 % of a chi-square with 3 degrees of freedom, those of a step of four wheels and two angles.
constexpr double kContradiction = 16.2662;

/// The twist is smoothed over this time [s]: that of one step has the noise of one step, divided by its short
/// duration.
constexpr double kTwistTime = 0.06;

/// Correlation lengths of the steering's error over which readings are compared: its mean then varies by 8 %
/// less than that of independent errors, and the angles hardly bend.
constexpr double kComparison = 2.0;

/// F J, with F = J_pose_pose() of the step.
template <typename Derivatives>
void carry(const PoseStep& moved, Derivatives& J) {
  J.row(0) -= moved.dy * J.row(2);
  J.row(1) += moved.dx * J.row(2);
}

/// F^-1 G, with F of the whole way from the beginning to `reached`.
Eigen::Matrix3d seenFromBeginning(Eigen::Matrix3d G, const Pose2& reached) {
  G(0, 2) += reached.y;
  G(1, 2) -= reached.x;
  return G;
}

double readingOf(double angle, const SteeringCalibration& steering) {
  return (angle - steering.offset) / steering.scale;
}

double adaptedAngle(double angle, const SteeringCalibration& from, const SteeringCalibration& to) {
  return to.scale * readingOf(angle, from) + to.offset;
}

SteeringAngles adapted(const SteeringAngles& angles, const Vehicle& from, const Vehicle& to) {
  SteeringAngles result;
  result.front = adaptedAngle(angles.front, from.steering.front, to.steering.front);
  result.rear = to.rear_steering.source == RearSteering::Source::kPolynomial
                    ? to.rear_steering.angle(result.front)
                    : adaptedAngle(angles.rear, from.steering.rear, to.steering.rear);
  return result;
}

}  // namespace

MotionModel::MotionModel(const Parameters& parameters)
    : configuration_(toConfiguration(parameters)),
      configured_(parameters.vehicle),
      values_(valuesOf(parameters)),
      model_(makeOdometryModel(configuration_)),
      comparison_length_(kComparison * configuration_.noise.steering.correlation_length) {}

void MotionModel::setValues(const ParameterVector& values) {
  values_ = values;
  calibration::setValues(values, configuration_.vehicle);
  model_ = makeOdometryModel(configuration_);
  for (const Wheel wheel : kAllWheels)
    gain_ratio_[wheel] = configuration_.vehicle.wheelGain(wheel) / configured_.wheelGain(wheel);
}

StepReadings MotionModel::adapted(const StepReadings& readings) const {
  const Vehicle& present = configuration_.vehicle;
  StepReadings result = readings;
  for (const Wheel wheel : kAllWheels) result.travel[wheel] = readings.travel[wheel] * gain_ratio_[wheel];
  result.begin = calibration::adapted(readings.begin, configured_, present);
  result.end = calibration::adapted(readings.end, configured_, present);
  return result;
}

/// A scale acts as an offset that grows with the reading.
MotionSensitivity MotionModel::sensitivity(const SystematicSensitivity& J,
                                           const StepReadings& readings) const {
  const SteeringAngles mean = readings.mean();
  const PerAxle<SteeringCalibration>& steering = configuration_.vehicle.steering;
  MotionSensitivity result;
  result.leftCols<systematic::kCount>() = J;
  result.col(kFrontScale) = J.col(systematic::kFrontOffset) * readingOf(mean.front, steering.front);
  result.col(kRearScale) = J.col(systematic::kRearOffset) * readingOf(mean.rear, steering.rear);
  return result;
}

/// Readings of which some cannot be trusted are compared with nothing.
void MotionModel::compare(const MeasuredStep& step, MotionSegment& segment) const {
  if (!std::holds_alternative<WheelFit>(model_)) return;
  if (step.steering_doubt.front > 0.0 || step.steering_doubt.rear > 0.0 || step.readings.leavesOut()) {
    segment.pending = PendingReadings();
    return;
  }
  const auto flush = [&] {
    addEvidence(adapted(segment.pending.readings()), segment.evidence);
    segment.pending = PendingReadings();
  };
  if (segment.pending.isReversedBy(step.readings)) flush();
  segment.pending.add(step.readings);
  if (segment.pending.length() >= comparison_length_) flush();
}

/// Steps whose readings contradict each other, as when a wheel slips, are believed less.
void MotionModel::addEvidence(const StepReadings& readings, Evidence& evidence) const {
  const auto* const fit = std::get_if<WheelFit>(&model_);
  if (!fit) return;
  const ParameterEvidence step = fit->evidence(readings);
  const double weight = std::min(1.0, kContradiction / step.chi_square);
  const SteeringAngles mean = readings.mean();
  const PerAxle<SteeringCalibration>& steering = configuration_.vehicle.steering;
  Eigen::Matrix<double, systematic::kCount, kMotionCount> T;
  T.setZero();
  T.leftCols<systematic::kCount>().setIdentity();
  T(systematic::kFrontOffset, kFrontScale) = readingOf(mean.front, steering.front);
  T(systematic::kRearOffset, kRearScale) = readingOf(mean.rear, steering.rear);
  evidence.information += weight * (T.transpose() * step.information * T);
  evidence.gradient += weight * (T.transpose() * step.gradient);
}

double MotionModel::move(const MeasuredStep& step, Pose2& pose) const {
  const StepReadings readings = adapted(step.readings);
  const BodyMotion motion = std::visit([&](const auto& model) { return model.motion(readings); }, model_);
  pose = advance(pose, motion).pose;
  return motion.head<2>().norm();
}

void MotionModel::extend(const MeasuredStep& step, MotionSegment& segment) const {
  const StepReadings readings = adapted(step.readings);
  const BodyIncrement increment = this->increment(readings);
  const PoseStep moved = advance(segment.motion, increment.motion);
  const Eigen::Matrix3d G = moved.J_pose_motion();
  const MotionSensitivity J = sensitivity(increment.J_motion_systematic, readings);
  compare(step, segment);
  advanceNoise(moved, increment.path_covariance, segment.noise);
  advanceSensitivity(moved, J, segment.J);
  segment.track_noise.add(increment, seenFromBeginning(G, moved.pose));
  if (step.steering_doubt.front > 0.0 || step.steering_doubt.rear > 0.0 || !segment.doubt.isZero(0.0)) {
    carry(moved, segment.doubt);
    segment.doubt.col(0) += G * J.col(systematic::kFrontOffset) * step.steering_doubt.front;
    segment.doubt.col(1) += G * J.col(systematic::kRearOffset) * step.steering_doubt.rear;
  }
  segment.motion = moved.pose;
  segment.distance += increment.motion.head<2>().norm();
  const double duration = toSeconds(step.span.end - step.span.begin);
  segment.duration += duration;
  if (!(duration > 0.0)) return;
  // A car that was not seen before has not been standing.
  const double share = segment.twist.isZero(0.0) ? 1.0 : 1.0 - std::exp(-duration / kTwistTime);
  segment.twist += share * (increment.motion / duration - segment.twist);
}

std::pair<MeasuredStep, MeasuredStep> split(const MeasuredStep& step, Time time) {
  const double share = toSeconds(time - step.span.begin) / toSeconds(step.span.end - step.span.begin);
  const auto between = [share](double begin, double end) { return begin + share * (end - begin); };
  std::pair<MeasuredStep, MeasuredStep> parts{step, step};
  parts.first.span.end = parts.second.span.begin = time;
  for (const Wheel wheel : kAllWheels) {
    const double travel = step.readings.travel[wheel];
    parts.first.readings.travel[wheel] = share * travel;
    parts.second.readings.travel[wheel] = travel - share * travel;
  }
  const SteeringAngles angles{between(step.readings.begin.front, step.readings.end.front),
                              between(step.readings.begin.rear, step.readings.end.rear)};
  parts.first.readings.end = parts.second.readings.begin = angles;
  return parts;
}

}  // namespace bs_car_odometry::calibration
