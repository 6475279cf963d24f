#include "bs_car_odometry/calibration/paper_filter.hpp"

#include "bs_car_odometry/calibration/planar.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::calibration {

namespace {

/// Of a distance taken with a tape [m]: two marks on the ground, each found to 7 mm.
constexpr double kTapeDeviation = 0.01;

Axle axleOf(const Parameters& parameters) {
  return parameters.odometry.axles == AxleSelection::kFront ? Axle::kFront : Axle::kRear;
}

/// With independent k_r and k_l.
double priorVarianceOfDistanceGain(const Eigen::Vector3d& variance, double right_share) {
  return right_share * right_share * variance(0) + (1.0 - right_share) * (1.0 - right_share) * variance(1);
}

}  // namespace

PaperFilter::PaperFilter(const Parameters& parameters)
    : vehicle_(parameters.vehicle),
      axle_(axleOf(parameters)),
      first_(axle_ == Axle::kFront ? systematic::kFrontRight : systematic::kRearRight),
      prior_(valuesOf(parameters).segment<3>(first_)),
      prior_variance_(priorDeviations(parameters).segment<3>(first_).cwiseAbs2()),
      wheel_variance_(parameters.noise.wheel.variance()),
      straight_limit_(parameters.calibration.straight_limit),
      mount_(mountOf(parameters.laser)),
      distance_(prior_.head<2>().mean(), priorVarianceOfDistanceGain(prior_variance_, 0.5)),
      model_(parameters) {
  state_.P.setZero();
  setGains(distance_.gain(), distance_.gainVariance());
}

void PaperFilter::begin(const LaserPose& laser) {
  begun_ = true;
  if (stage_ == 1 && straight_end_ == StraightEnd::kOver) return beginStage2(laser);
  setPose(laser);
  if (stage_ == 1) beginDistance(laser);
}

/// What a laser pose says of base_link, and nothing else.
void PaperFilter::setPose(const LaserPose& laser) {
  state_.pose = laser.pose * inverse(mount_);
  const Eigen::Matrix3d J = leverArm(state_.pose.position() - laser.pose.position());
  state_.P.topRows<3>().setZero();
  state_.P.leftCols<3>().setZero();
  state_.P.topLeftCorner<3, 3>() = J * laser.covariance * J.transpose();
  const BodyMotion twist = segment_.twist;
  segment_ = MotionSegment();
  segment_.twist = twist;
}

/// (C4) The prior of (k_r, k_b), given k_d: k_r and k_l were independent, and k_d is their mean.
void PaperFilter::setGains(double k_d, double variance) {
  const double share = relation_.rightShare();
  const double prior_k_d = share * prior_(0) + (1.0 - share) * prior_(1);
  const double prior_variance = priorVarianceOfDistanceGain(prior_variance_, share);
  const double slope = share * prior_variance_(0) / prior_variance;  // E[k_r | k_d] over k_d
  state_.gains << prior_(0) + slope * (k_d - prior_k_d), prior_(2), k_d;
  StateMatrix& P = state_.P;
  P.bottomRows<3>().setZero();
  P.rightCols<3>().setZero();
  P(kRight, kRight) = prior_variance_(0) + slope * slope * (variance - prior_variance);
  P(kRight, kDistanceGain) = P(kDistanceGain, kRight) = slope * variance;
  P(kDistanceGain, kDistanceGain) = variance;
  P(kTrack, kTrack) = prior_variance_(2);
}

/// From one laser pose that stage 1 has not used, so that the two stages share no error. The pose that ran
/// along in stage 1 is tied to gains at their prior.
void PaperFilter::beginStage2(const LaserPose& laser) {
  stage_ = 2;
  relation_ = run_;
  setGains(distance_.gain(), distance_.gainVariance());
  setPose(laser);
  useGains();
}

void PaperFilter::setStraightRun(bool lasts) {
  if (stage_ == 1) straight_end_ = lasts ? StraightEnd::kWhenTold : StraightEnd::kOver;
}

void PaperFilter::takeTapedRun(const std::vector<MeasuredStep>& run, double distance) {
  if (stage_ != 1) return;
  distance_.begin(0.0);
  for (const MeasuredStep& step : run) addToRun(step);
  distance_.update(std::copysign(distance, distance_.distance()), kTapeDeviation * kTapeDeviation);
  straight_end_ = StraightEnd::kOver;
}

void PaperFilter::setDistanceGain(double k_d, double variance, const StraightRun& run) {
  distance_ = DistanceGainFilter(k_d, variance);
  run_ = run;
  straight_end_ = StraightEnd::kOver;
}

void PaperFilter::move(const MeasuredStep& step) {
  if (stage_ == 1 && begun_) followStraightRun(step);
  model_.extend(step, segment_);
}

void PaperFilter::followStraightRun(const MeasuredStep& step) {
  const StepReadings& readings = step.readings;
  const double largest = std::max(std::abs(readings.begin[axle_]), std::abs(readings.end[axle_]));
  if (straight_end_ == StraightEnd::kByAngle && largest > straight_limit_) straight_end_ = StraightEnd::kOver;
  if (straight_end_ == StraightEnd::kOver) return;
  angle_ = readings.mean()[axle_];
  addToRun(step);
}

void PaperFilter::addToRun(const MeasuredStep& step) {
  const AxleGains& gains = vehicle_.gains[axle_];
  const double right = step.readings.travel[rightWheel(axle_)];
  const double left = step.readings.travel[leftWheel(axle_)];
  distance_.move(0.5 * (right / gains.k_r + left / gains.k_l),
                 0.25 * wheel_variance_ * (std::abs(right) + std::abs(left)));
  run_.right += std::abs(right / gains.k_r);
  run_.left += std::abs(left / gains.k_l);
}

/// (C2) The laser's own error along the run is that of the place where S = 0 is. Each later pose then brings
/// an error of its own, and only that one.
void PaperFilter::beginDistance(const LaserPose& laser) {
  const Pose2 middle = laser.pose * inverse(mount_) * Pose2{vehicle_.axleX(axle_), 0.0, 0.0};
  const Eigen::Matrix3d J = leverArm(middle.position() - laser.pose.position());
  const Eigen::Vector3d along(std::cos(middle.yaw), std::sin(middle.yaw), 0.0);
  reference_ = middle.position();
  reference_distance_ = 0.0;
  distance_.begin(along.dot(J * laser.covariance * J.transpose() * along));
}

/// (C2) How far the laser has seen the middle of the axle go, along the way it goes. Not the distance between
/// the first place and this one, which is shorter on a run that swerves, and longer than none at rest.
/// @param yaw     of the body, better known than by one laser pose
/// @param weight  of the laser pose as a whole
void PaperFilter::measureDistance(const LaserPose& laser, double yaw, double weight) {
  if (weight <= 0.0) return;
  const Pose2 middle = laser.pose * inverse(mount_) * Pose2{vehicle_.axleX(axle_), 0.0, 0.0};
  const Eigen::Matrix3d J = leverArm(middle.position() - laser.pose.position());
  const Eigen::Vector3d along(std::cos(yaw + angle_), std::sin(yaw + angle_), 0.0);
  const double distance = reference_distance_ + along.head<2>().dot(middle.position() - reference_);
  const double variance = along.dot(J * laser.covariance * J.transpose() * along);
  const double own_weight = distance_.update(distance, variance / weight);
  if (weight < 1.0 || own_weight < 1.0) return;  // what is to come is not measured from an outlier
  reference_ = middle.position();
  reference_distance_ = distance;
}

/// (C5) Columns k_r, k_b, k_d of the motion's derivative, k_l being a function of k_r and k_d.
Eigen::Matrix3d PaperFilter::gainColumns(const MotionSensitivity& J) const {
  Eigen::Matrix3d columns;
  columns.col(0) = J.col(first_) + J.col(first_ + 1) * relation_.leftGainByRightGain();
  columns.col(1) = J.col(first_ + 2);
  columns.col(2) = J.col(first_ + 1) * relation_.leftGainByDistanceGain();
  return columns;
}

PaperFilter::State PaperFilter::predicted() const {
  const Eigen::Matrix3d R = rotation(state_.pose.yaw);
  State state;
  state.pose = state_.pose * segment_.motion;
  state.gains = state_.gains;
  StateMatrix F = StateMatrix::Identity();
  F.topLeftCorner<3, 3>() = leverArm(state.pose.position() - state_.pose.position());
  F.topRightCorner<3, 3>() = R * gainColumns(segment_.J);
  state.P = F * state_.P * F.transpose();
  state.P.topLeftCorner<3, 3>() += R * segment_.covariance() * R.transpose();
  return state;
}

PaperFilter::MeasurementJacobian PaperFilter::measurementJacobian(const Pose2& base) const {
  MeasurementJacobian H = MeasurementJacobian::Zero();
  H.leftCols<3>() = leverArm((base * mount_).position() - base.position());
  return H;
}

Innovation PaperFilter::update(const LaserPose& laser, double lead) {
  const State state = predicted();
  LaserPose present = laser;  // where it would have been seen now
  present.pose = laser.pose * inverse(mount_) * exp(-lead * segment_.twist) * mount_;
  const MeasurementJacobian H = measurementJacobian(state.pose);
  Innovation innovation;
  innovation.residual = present.pose.vector() - (state.pose * mount_).vector();
  innovation.residual.z() = wrapAngle(innovation.residual.z());
  innovation.covariance = H * state.P * H.transpose() + laser.covariance;
  innovation.nis = innovation.residual.dot(innovation.covariance.llt().solve(innovation.residual));
  innovation.weight = std::min(1.0, kSoftLimit / innovation.nis);
  const bool straight_over = straight_end_ == StraightEnd::kOver;
  if (stage_ == 1 && straight_over && innovation.weight == 1.0) {
    beginStage2(present);
    return innovation;
  }
  if (!correct(state, present, innovation)) innovation.weight = 0.0;
  if (stage_ == 1 && !straight_over) measureDistance(present, state_.pose.yaw, innovation.weight);
  return innovation;
}

/// (C5) Joseph form, which holds for any gain: that of what is only considered is zero, k_d in stage 2, every
/// gain in stage 1.
/// @return false when the result was not finite: then nothing has changed
bool PaperFilter::correct(const State& state, const LaserPose& laser, const Innovation& innovation) {
  const MeasurementJacobian H = measurementJacobian(state.pose);
  const Eigen::Matrix3d R = laser.covariance / innovation.weight;
  const MeasurementJacobian HP = H * state.P;
  const Eigen::Matrix3d S = HP * H.transpose() + R;
  Eigen::Matrix<double, kStates, 3> K = S.llt().solve(HP).transpose();
  K.bottomRows(stage_ == 1 ? kStates - kRight : kStates - kDistanceGain).setZero();
  const Eigen::Matrix<double, kStates, 1> change = K * innovation.residual;
  const StateMatrix I_KH = StateMatrix::Identity() - K * H;
  const StateMatrix P = I_KH * state.P * I_KH.transpose() + K * R * K.transpose();
  if (!change.allFinite() || !P.allFinite()) return false;
  state_.P = 0.5 * (P + P.transpose());
  state_.pose = {state.pose.x + change(kX), state.pose.y + change(kY), state.pose.yaw + change(kYaw)};
  state_.gains = state.gains + change.tail<3>();
  const BodyMotion twist = segment_.twist;
  segment_ = MotionSegment();
  segment_.twist = twist;
  if (stage_ == 2) useGains();
  return true;
}

/// The model takes the present gains.
void PaperFilter::useGains() {
  const double k_r = state_.gains(0);
  ParameterVector values = model_.values();
  values.segment<3>(first_) << k_r, relation_.leftGain(state_.gains(2), k_r), state_.gains(1);
  model_.setValues(values);
}

FilterEstimate PaperFilter::estimate() const {
  const State state = predicted();
  FilterEstimate estimate;
  estimate.pose = state.pose;
  estimate.pose_covariance = state.P.topLeftCorner<3, 3>();
  estimate.values = model_.values();
  Eigen::Matrix3d T;  // (k_r, k_l, k_b) over (k_r, k_b, k_d)
  T << 1.0, 0.0, 0.0, relation_.leftGainByRightGain(), 0.0, relation_.leftGainByDistanceGain(), 0.0, 1.0, 0.0;
  estimate.covariance.block<3, 3>(first_, first_) = T * state.P.bottomRightCorner<3, 3>() * T.transpose();
  setDistanceGains(vehicle_, estimate);
  estimate.k_d[axle_] = stage_ == 1 ? distance_.gain() : state.gains(2);
  estimate.k_d_variance[axle_] =
      stage_ == 1 ? distance_.gainVariance() : state.P(kDistanceGain, kDistanceGain);
  estimate.stage = stage_;
  return estimate;
}

}  // namespace bs_car_odometry::calibration
