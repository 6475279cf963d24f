#include "bs_car_odometry/core/odometry_estimator.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

namespace {

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

/// Far above anything a car can do, and far below what overflows when such steps are multiplied and added up.
constexpr double kLargest = 1e30;

/// The covariance, or the same made smaller where what it leads to might overflow. A pose that is not known
/// to 1e15 m is not known.
Eigen::Matrix3d bounded(const Eigen::Matrix3d& covariance) {
  return covariance * std::min(1.0, kLargest / covariance.cwiseAbs().maxCoeff());
}

/// False for values that are not finite, too.
bool isUsable(const BodyIncrement& increment) {
  // The entries of a covariance are no larger than its trace, and the sensitivities are made of what motion
  // and covariance are made of.
  const double variances = increment.path_covariance.trace() + increment.step_covariance.trace();
  return increment.motion.squaredNorm() + variances < kLargest;
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

PerWheel<bool> wheelsUsed(const Vehicle& vehicle, const OdometryOptions& options) {
  PerWheel<bool> used;
  for (const Wheel wheel : kAllWheels) {
    const bool selected = options.axles == AxleSelection::kBoth ||
                          (options.axles == AxleSelection::kFront) == (axleOf(wheel) == Axle::kFront);
    used[wheel] = selected && vehicle.hasEncoder(wheel);
  }
  return used;
}

double longestStep(const InputLimits& limits, Duration interval) {
  constexpr double kPlausibleExcess = 1.5;
  return limits.max_speed * (kPlausibleExcess * toSeconds(interval) + toSeconds(kStampJitter));
}

Eigen::Vector3d unseenMotion(const OdometryConfiguration& configuration, Duration interval) {
  const double distance = configuration.limits.max_speed * toSeconds(interval);
  const double turn = std::min(distance / configuration.vehicle.wheelbase, M_PI);
  return Eigen::Vector3d(distance, distance, turn).array().square();
}

OdometryEstimator::OdometryEstimator(const OdometryConfiguration& configuration)
    : configuration_(configuration),
      model_(makeOdometryModel(configuration)),
      systematic_root_(systematicCovariance(configuration)),
      uncertainty_(makePoseUncertainty(configuration)) {
  reset();
}

void OdometryEstimator::reset() {
  const InitialPose& initial = configuration_.initial_pose;
  setPose({initial.x, initial.y, initial.yaw}, initial.covariance);
  increment_ = BodyIncrement();
}

void OdometryEstimator::setPose(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  dead_reckoned_ = before_step_ = pose;
  uncertainty_->reset(pose, bounded(covariance));
  steering_doubt_.reset();
  publishPose();
  forgetTwist();
}

void OdometryEstimator::setSystematicCovariance(const SystematicCovariance& covariance) {
  const SystematicRoot before = systematic_root_;
  systematic_root_ = SystematicRoot(covariance);
  configuration_.systematic_covariance = covariance;
  uncertainty_->setSystematic(SystematicPrior(covariance, configuration_),
                              carriedOver(before, systematic_root_));
}

void OdometryEstimator::setCalibration(const OdometryCalibration& calibration) {
  configuration_.vehicle.gains = calibration.gains;
  configuration_.vehicle.steering = calibration.steering;
  model_ = makeOdometryModel(configuration_);
  setSystematicCovariance(calibration.covariance);
}

const FitResiduals& OdometryEstimator::read(const StepReadings& readings) {
  std::visit([&](const auto& model) { model.update(readings, increment_); }, model_);
  return increment_.residuals;
}

/// One piece of code (flatten), see WheelFit::update.
[[gnu::flatten]] bool OdometryEstimator::move(const StepReadings& readings,
                                              std::optional<Duration> interval) {
  if (!isUsable(increment_)) {
    refuseStep(interval);
    return false;
  }
  const SystematicSensitivity J_motion = systematic_root_(increment_.J_motion_systematic);
  const PoseStep moved = advance(dead_reckoned_, increment_.motion);
  before_step_ = dead_reckoned_;
  dead_reckoned_ = moved.pose;
  uncertainty_->advance({moved, increment_, J_motion, readings, model_});
  estimate_.pose = uncertainty_->mean().value_or(dead_reckoned_);
  uncertainty_->getTotal(estimate_.pose_covariance);
  updateTwist(interval, J_motion);
  return true;
}

void OdometryEstimator::doubtSteering(std::optional<Duration> interval, const PerAxle<double>& sigma) {
  const bool doubt = sigma.front > 0.0 || sigma.rear > 0.0;
  if (!doubt && !steering_doubt_.isActive()) return;
  steering_doubt_.advance(advance(before_step_, increment_.motion), increment_.J_motion_systematic, sigma);
  if (doubt) {
    SteeringDoubt of_step;
    of_step.advance(PoseStep(), increment_.J_motion_systematic, sigma);
    if (interval) estimate_.twist_covariance += of_step.share() / std::pow(toSeconds(*interval), 2);
  } else {
    // Trusted again: what the doubt has done stays, and the next one is a new error.
    uncertainty_->inflate(steering_doubt_.share());
    steering_doubt_.reset();
  }
  publishPose();
}

void OdometryEstimator::publishPose() {
  estimate_.pose = uncertainty_->mean().value_or(dead_reckoned_);
  estimate_.pose_covariance = uncertainty_->total() + steering_doubt_.share();
}

void OdometryEstimator::refuseStep(std::optional<Duration> interval) {
  increment_ = BodyIncrement();
  before_step_ = dead_reckoned_;
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
  inflate(Eigen::Matrix3d(unseenMotion(configuration_, interval).asDiagonal()));
}

void OdometryEstimator::inflate(const Eigen::Matrix3d& covariance) {
  uncertainty_->inflate(covariance);
  publishPose();
}

void OdometryEstimator::forgetTwist() {
  const double max_speed = configuration_.limits.max_speed;
  const double max_yaw_rate = max_speed / configuration_.vehicle.wheelbase;
  estimate_.twist.setZero();
  estimate_.twist_covariance =
      Eigen::Vector3d(max_speed, max_speed, max_yaw_rate).array().square().matrix().asDiagonal();
}

}  // namespace bs_car_odometry
