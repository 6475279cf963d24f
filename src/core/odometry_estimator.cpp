#include "bs_car_odometry/core/odometry_estimator.hpp"

#include <cmath>

namespace bs_car_odometry {

namespace {

using Model = std::variant<WheelFit, AxleOdometry>;

Model makeModel(const OdometryConfiguration& c) {
  if (c.options.axles == AxleSelection::kBoth) return WheelFit(c.vehicle, c.noise);
  const Axle axle = c.options.axles == AxleSelection::kFront ? Axle::kFront : Axle::kRear;
  return AxleOdometry(c.vehicle, c.noise, c.options, axle);
}

/// With a hub offset the wheels' directions enter, and those of Ackermann axles follow from both angles,
/// unless the axle is fixed straight ahead.
bool otherAngleMatters(const Vehicle& vehicle, const OdometryOptions& options, Axle axle) {
  if (options.motion == Motion::kPaper || vehicle.axle_geometry == AxleGeometry::kPivot) return false;
  if (vehicle.hub_offset[axle] == 0.0) return false;
  const RearSteering& rear = vehicle.rear_steering;
  const bool fixed_straight = axle == Axle::kRear && rear.source == RearSteering::Source::kPolynomial &&
                              rear.isConstant() && rear.angle(0.0) == 0.0;
  return !fixed_straight;
}

/// Of a symmetric matrix.
bool isFinite(const Eigen::Matrix3d& m) {
  return std::isfinite(m(0, 0) + m(0, 1) + m(0, 2) + m(1, 1) + m(1, 2) + m(2, 2));
}

}  // namespace

PerAxle<bool> steeringNeeded(const Vehicle& vehicle, const OdometryOptions& options) {
  const bool measured = vehicle.rear_steering.source == RearSteering::Source::kMeasured;
  if (options.axles == AxleSelection::kBoth) return {true, measured};
  if (options.axles == AxleSelection::kFront)
    return {true, measured && otherAngleMatters(vehicle, options, Axle::kFront)};
  const bool other = otherAngleMatters(vehicle, options, Axle::kRear);
  if (measured) return {other, true};
  return {other || !vehicle.rear_steering.isConstant(), false};
}

OdometryEstimator::OdometryEstimator(const OdometryConfiguration& configuration)
    : configuration_(configuration),
      model_(makeModel(configuration)),
      systematic_root_(systematicCovariance(configuration.noise.systematic)),
      covariance_(configuration.initial_pose.covariance) {
  reset();
}

void OdometryEstimator::reset() {
  const InitialPose& initial = configuration_.initial_pose;
  setPose({initial.x, initial.y, initial.yaw}, initial.covariance);
  increment_ = BodyIncrement();
}

void OdometryEstimator::setPose(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  covariance_.reset(covariance);
  steering_doubt_.reset();
  estimate_.pose = pose;
  estimate_.pose_covariance = covariance_.noise();
  forgetTwist();
}

void OdometryEstimator::setSystematicCovariance(const SystematicCovariance& covariance) {
  covariance_.settleSystematic();
  systematic_root_ = SystematicRoot(covariance);
}

/// One piece of code (flatten), see WheelFit::update.
[[gnu::flatten]] bool OdometryEstimator::step(const StepReadings& readings,
                                              std::optional<Duration> interval) {
  std::visit([&](const auto& model) { model.update(readings, increment_); }, model_);
  const SystematicSensitivity J_motion = systematic_root_(increment_.J_motion_systematic);
  const PoseStep moved = advance(estimate_.pose, increment_.motion);

  const Pose2 pose_before = estimate_.pose;
  const FirstOrderCovariance covariance_before = covariance_;
  estimate_.pose = moved.pose;
  covariance_.advance(moved, increment_.path_covariance, J_motion);
  covariance_.getTotal(estimate_.pose_covariance);
  if (!estimate_.pose.isFinite() || !isFinite(estimate_.pose_covariance) ||
      !isFinite(increment_.step_covariance)) {
    estimate_.pose = pose_before;
    covariance_ = covariance_before;
    refuseStep(interval);
    return false;
  }
  updateTwist(interval, J_motion);
  return true;
}

void OdometryEstimator::doubtSteering(const Pose2& before, std::optional<Duration> interval,
                                      const PerAxle<double>& sigma) {
  const bool doubt = sigma.front > 0.0 || sigma.rear > 0.0;
  if (!doubt && !steering_doubt_.isActive()) return;
  steering_doubt_.advance(advance(before, increment_.motion), increment_.J_motion_systematic, sigma);
  if (doubt) {
    setPoseCovariance();
    SteeringDoubt of_step;
    of_step.advance(PoseStep(), increment_.J_motion_systematic, sigma);
    if (interval) estimate_.twist_covariance += of_step.share() / std::pow(toSeconds(*interval), 2);
  } else {
    // Trusted again: what the doubt has done stays, and the next one is a new error.
    covariance_.inflate(steering_doubt_.share());
    steering_doubt_.reset();
    setPoseCovariance();
  }
}

void OdometryEstimator::setPoseCovariance() {
  estimate_.pose_covariance = covariance_.total() + steering_doubt_.share();
}

void OdometryEstimator::refuseStep(std::optional<Duration> interval) {
  increment_ = BodyIncrement();
  inflate(interval.value_or(configuration_.limits.max_gap));
  forgetTwist();
}

void OdometryEstimator::updateTwist(std::optional<Duration> interval, const SystematicSensitivity& J_motion) {
  if (!interval || *interval <= Duration::zero()) return forgetTwist();
  const double rate = 1.0 / toSeconds(*interval);
  estimate_.twist = increment_.motion * rate;
  setTotal(increment_.step_covariance, J_motion, rate * rate, estimate_.twist_covariance);
}

void OdometryEstimator::inflate(Duration interval) {
  const double distance = configuration_.limits.max_speed * toSeconds(interval);
  const double turn = std::min(distance / configuration_.vehicle.wheelbase, M_PI);
  covariance_.inflate(Eigen::Vector3d(distance, distance, turn).array().square().matrix().asDiagonal());
  setPoseCovariance();
}

void OdometryEstimator::forgetTwist() {
  const double max_speed = configuration_.limits.max_speed;
  const double max_yaw_rate = max_speed / configuration_.vehicle.wheelbase;
  estimate_.twist.setZero();
  estimate_.twist_covariance =
      Eigen::Vector3d(max_speed, max_speed, max_yaw_rate).array().square().matrix().asDiagonal();
}

}  // namespace bs_car_odometry
