#include "bs_car_odometry/core/odometry_pipeline.hpp"

#include "bs_car_odometry/core/nearest_covariance.hpp"
#include "bs_car_odometry/core/wheel_counters.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

namespace {

/// Wheel messages that may wait for steering: at 1 kHz as long as steering_wait may be.
constexpr std::size_t kMostWaiting = 2048;

/// In the order of `systematic`.
Eigen::Matrix<double, systematic::kCount, 1> systematicValues(const OdometryCalibration& calibration) {
  const PerAxle<AxleGains>& gains = calibration.gains;
  Eigen::Matrix<double, systematic::kCount, 1> values;
  values << gains.front.k_r, gains.front.k_l, gains.front.k_b, calibration.steering.front.offset,
      gains.rear.k_r, gains.rear.k_l, gains.rear.k_b, calibration.steering.rear.offset;
  return values;
}

PerAxle<double> larger(const PerAxle<double>& a, const PerAxle<double>& b) {
  return {std::max(a.front, b.front), std::max(a.rear, b.rear)};
}

OdometryConfiguration withCleanCovariance(OdometryConfiguration configuration) {
  configuration.initial_pose.covariance = withoutNegativeVariances(configuration.initial_pose.covariance);
  return configuration;
}

}  // namespace

OdometryPipeline::OdometryPipeline(const OdometryConfiguration& configuration)
    : configuration_(configuration),
      steering_needed_(bs_car_odometry::steeringNeeded(configuration.vehicle, configuration.options)),
      wheel_used_(wheelsUsed(configuration.vehicle, configuration.options)),
      estimator_(withCleanCovariance(configuration)),
      monitor_(configuration),
      motion_history_(configuration.relative_motion.history, systematicCovariance(configuration)) {
  waiting_.reserve(kMostWaiting);
}

Verdict OdometryPipeline::count(Verdict verdict) {
  ++counts_.verdicts[static_cast<std::size_t>(verdict)];
  return verdict;
}

Verdict OdometryPipeline::reject(Verdict verdict) { return count(verdict); }

Verdict OdometryPipeline::checkStamp(Time stamp, Time receipt) {
  if (stamp == Time()) return Verdict::kStampZero;
  if (stamp <= receipt + configuration_.limits.max_future) return Verdict::kAccepted;
  counts_.ahead = stamp - receipt;
  return Verdict::kFuture;
}

Verdict OdometryPipeline::addSteering(Axle axle, Time stamp, Time receipt, double reading) {
  const Verdict stamped = checkStamp(stamp, receipt);
  if (stamped != Verdict::kAccepted) return count(stamped);
  if (!std::isfinite(reading)) return count(Verdict::kNotFinite);
  const SteeringCalibration& calibration = configuration_.vehicle.steering[axle];
  const double angle = calibration.scale * reading + calibration.offset;
  if (std::abs(angle) > configuration_.limits.steering_limit) {
    counts_.refused_angle = angle;
    return count(Verdict::kSteeringLimit);
  }
  switch (steering_[axle].insert(stamp, reading)) {
    case SteeringBuffer::Inserted::kRepeated:
      return count(Verdict::kRepeated);
    case SteeringBuffer::Inserted::kTooOld:
      return count(Verdict::kOutOfOrder);
    case SteeringBuffer::Inserted::kYes:
      break;
  }
  ++counts_.steering_messages;
  return Verdict::kAccepted;
}

Verdict OdometryPipeline::addWheels(const WheelCounts& counts) {
  const Verdict stamped = checkStamp(counts.stamp, counts.receipt);
  if (stamped != Verdict::kAccepted) return count(stamped);
  if (newest_wheels_ && counts.stamp == *newest_wheels_) return count(Verdict::kRepeated);
  if (newest_wheels_ && counts.stamp < *newest_wheels_) return count(Verdict::kOutOfOrder);
  if (waiting_.size() >= kMostWaiting) return count(Verdict::kOverflow);
  newest_wheels_ = counts.stamp;
  waiting_.push_back(counts);
  return Verdict::kAccepted;
}

bool OdometryPipeline::steeringReaches(Time stamp) const {
  for (const Axle axle : kAllAxles)
    if (steering_needed_[axle] && (steering_[axle].empty() || *steering_[axle].newest() < stamp))
      return false;
  return true;
}

bool OdometryPipeline::steeringKnown() const {
  for (const Axle axle : kAllAxles)
    if (steering_needed_[axle] && steering_[axle].empty()) return false;
  return true;
}

bool OdometryPipeline::steeringReachesBack(Time stamp) const {
  for (const Axle axle : kAllAxles)
    if (steering_needed_[axle] && stamp < *steering_[axle].oldest()) return false;
  return true;
}

std::optional<Time> OdometryPipeline::deadline() const {
  if (waiting_.empty()) return std::nullopt;
  return waiting_.front().receipt + configuration_.limits.steering_wait;
}

std::optional<OdometryUpdate> OdometryPipeline::next(Time now) {
  while (!waiting_.empty()) {
    const bool complete = steeringReaches(waiting_.front().stamp);
    if (!complete && now < *deadline()) return std::nullopt;
    const Time completed = complete ? now : *deadline();
    const WheelCounts counts = waiting_.front();
    waiting_.erase(waiting_.begin());
    if (!steeringKnown()) {
      count(Verdict::kNoSteering);
      continue;
    }
    if (!complete) ++counts_.steering_held;
    if (auto update = process(counts, completed)) return update;
  }
  return std::nullopt;
}

std::optional<OdometryUpdate> OdometryPipeline::process(const WheelCounts& counts, Time completed) {
  const double distance = report_.distance;
  report_ = StepReport();
  step_.reset();
  report_.distance = distance;
  report_.steering_age = steeringAges(counts.stamp);
  const double oldest = std::max(report_.steering_age.front, report_.steering_age.rear);
  if (oldest > toSeconds(configuration_.limits.max_steering_age)) report_.state = OdometryState::kNoSteering;
  if (!reference_) {
    last_readings_ = steeringReadingsAt(counts.stamp);
    const SteeringAngles angles = anglesOf(last_readings_);
    report_.steering_angle = {angles.front, angles.rear};
    reference_ = counts;
    reference_time_known_ = true;
  } else if (reference_time_known_ && isAmbiguous(counts.stamp - reference_->stamp)) {
    takeAnew(counts);
  } else if (takeReference(counts)) {
    move(counts);
  } else {
    count(Verdict::kImplausible);
    return std::nullopt;
  }
  return update(counts, completed);
}

PerWheel<double> OdometryPipeline::travels(const WheelCounts& from, const WheelCounts& to) const {
  PerWheel<double> travels;
  for (const Wheel wheel : kAllWheels) {
    if (!wheel_used_[wheel]) continue;
    const std::int64_t ticks =
        counterDifference(to.ticks[wheel], from.ticks[wheel], configuration_.vehicle.counter_bits);
    travels[wheel] = configuration_.vehicle.calibratedMetresPerTick(wheel) * static_cast<double>(ticks);
  }
  return travels;
}

/// Of what was read last. Wheels that contradict each other and the angles can fit to a motion that is longer
/// than that of any of them.
bool OdometryPipeline::isPlausible(Duration interval) const {
  const double longest = longestStep(configuration_.limits, interval);
  return estimator_.lastIncrement().motion.head<2>().norm() <= longest;
}

PerWheel<bool> OdometryPipeline::jumps(const WheelCounts& from, const WheelCounts& to,
                                       Duration interval) const {
  const double longest = longestStep(configuration_.limits, interval);
  const PerWheel<double> travels = this->travels(from, to);
  PerWheel<bool> jumps;
  for (const Wheel wheel : kAllWheels) jumps[wheel] = std::abs(travels[wheel]) > longest;
  return jumps;
}

/// Makes sure that the counters can be taken from the reference. A wheel whose counter jumped is left out
/// where the others are enough. Else the message is; and when the next one follows the jump, the counters
/// have been restarted, and the jump becomes the new reference.
/// @return false when `counts` must be left out
bool OdometryPipeline::takeReference(const WheelCounts& counts) {
  const auto jumpsFrom = [&](const WheelCounts& from, bool time_known) {
    return jumps(from, counts, time_known ? counts.stamp - from.stamp : configuration_.limits.max_gap);
  };
  jumped_ = jumpsFrom(*reference_, reference_time_known_);
  if (jumped_ == PerWheel<bool>() || monitor_.canDoWithout(jumped_)) {
    for (const bool jumped : jumped_.values) counts_.wheel_jumps += jumped ? 1 : 0;
    suspicious_.reset();
    return true;
  }
  if (!suspicious_ || !(jumpsFrom(*suspicious_, true) == PerWheel<bool>())) {
    suspicious_ = counts;
    return false;
  }
  ++counts_.counter_restarts;
  estimator_.inflate(reference_time_known_ ? suspicious_->stamp - reference_->stamp
                                           : configuration_.limits.max_gap);
  if (reference_time_known_) rememberUnseen({reference_->stamp, suspicious_->stamp});
  reference_ = suspicious_;
  reference_time_known_ = true;
  suspicious_.reset();
  jumped_ = jumped_before_ = PerWheel<bool>();
  return true;
}

/// A travel is known where the counter jumped at neither end of the step.
void OdometryPipeline::leaveOutJumps(StepReadings& readings) {
  for (const Wheel wheel : kAllWheels) {
    readings.left_out[wheel] = jumped_[wheel] || jumped_before_[wheel];
    if (readings.left_out[wheel]) readings.travel[wheel] = 0.0;
  }
  jumped_before_ = jumped_;
}

/// True for a gap in which a wheel may have turned by half of its counter's range, so that which way and how
/// far it went is lost.
bool OdometryPipeline::isAmbiguous(Duration interval) const {
  const Vehicle& vehicle = configuration_.vehicle;
  if (interval <= configuration_.limits.max_gap || vehicle.counter_bits <= 0) return false;
  const double furthest = configuration_.limits.max_speed * toSeconds(interval);
  const double half_range = std::ldexp(1.0, vehicle.counter_bits - 1);
  for (const Wheel wheel : kAllWheels)
    if (wheel_used_[wheel] && std::abs(vehicle.calibratedMetresPerTick(wheel)) * half_range < furthest)
      return true;
  return false;
}

/// The car stays where it was, as far as is known, and may be anywhere around.
void OdometryPipeline::takeAnew(const WheelCounts& counts) {
  const TimeSpan unseen{reference_->stamp, counts.stamp};
  ++counts_.gaps;
  ++counts_.ambiguous_gaps;
  report_.interval = toSeconds(unseen.end - unseen.begin);
  estimator_.inflate(unseen.end - unseen.begin);
  estimator_.forgetTwist();
  rememberUnseen(unseen);
  last_readings_ = steeringReadingsAt(counts.stamp);
  reference_ = counts;
  suspicious_.reset();
  jumped_ = jumped_before_ = PerWheel<bool>();
}

/// Also takes the steering at its end as that of the next reference.
StepReadings OdometryPipeline::readingsUntil(const WheelCounts& counts) {
  StepReadings readings;
  readings.travel = travels(*reference_, counts);
  leaveOutJumps(readings);
  // After a long interval, or in a new time, the buffer may begin after the reference.
  const bool reaches_back = reference_time_known_ && steeringReachesBack(reference_->stamp);
  readings.begin = anglesOf(reaches_back ? steeringReadingsAt(reference_->stamp) : last_readings_);
  last_readings_ = steeringReadingsAt(counts.stamp);
  readings.end = anglesOf(last_readings_);
  return readings;
}

/// From the reference, where that is known in this time.
std::optional<TimeSpan> OdometryPipeline::spanUntil(const WheelCounts& counts) const {
  if (!reference_time_known_) return std::nullopt;
  return TimeSpan{reference_->stamp, counts.stamp};
}

/// The duration of a step without a gap.
std::optional<Duration> OdometryPipeline::noteInterval(const std::optional<TimeSpan>& span) {
  if (!span) return std::nullopt;
  const Duration interval = span->end - span->begin;
  report_.interval = toSeconds(interval);
  if (interval <= configuration_.limits.max_gap) return interval;
  ++counts_.gaps;
  return std::nullopt;
}

void OdometryPipeline::move(const WheelCounts& counts) {
  StepReadings measured = readingsUntil(counts);
  const std::optional<TimeSpan> span = spanUntil(counts);
  const std::optional<Duration> interval = noteInterval(span);
  reference_ = counts;
  reference_time_known_ = true;
  const PerAxle<double> doubt = steeringDoubt(report_.interval);
  // Inside a gap no single angle is to be found by the wheels.
  if (interval) measured.steering_doubt = doubt;
  const StepReadings readings = read(measured, interval.has_value());
  const Duration known = span ? span->end - span->begin : configuration_.limits.max_gap;
  const bool plausible = isPlausible(known);
  if (!plausible) estimator_.refuseStep(known + kStampJitter);
  if (!plausible || !estimator_.move(readings, interval)) {
    // What was not finite must not leave by the report either.
    ++counts_.refused_states;
    report_.state = OdometryState::kDegraded;
    if (span) rememberUnseen(*span);
    return;
  }
  const PerAxle<double> total_doubt = larger(doubt, readings.steering_doubt);
  estimator_.doubtSteering(interval, total_doubt);
  Eigen::Matrix3d unforeseen = watch(measured, interval);
  if (span && !interval) unforeseen.diagonal() += bendPath(readings, total_doubt);
  if (span) {
    rememberStep(*span, interval.has_value(), total_doubt, unforeseen);
    step_ = {*span, readings, total_doubt};
  }
  reportStep(measured, readings.left_out);
}

/// As it was measured, or without what contradicts the rest. Over a gap everything does: the steering inside
/// it is not known.
StepReadings OdometryPipeline::read(const StepReadings& measured, bool seen) {
  StepReadings readings = monitor_.distrusts(measured) ? monitor_.trusted(measured) : measured;
  for (std::size_t round = 0; round < kSensors; ++round) {
    const FitResiduals& residuals = estimator_.read(readings);
    if (!seen || !monitor_.contradicts(readings, residuals)) break;
    readings = monitor_.trusted(measured);
  }
  return readings;
}

/// What a fault has done to the pose before it was found is an error of the pose.
/// @return its covariance (x, y, yaw), axes of base_link
Eigen::Matrix3d OdometryPipeline::watch(const StepReadings& measured, std::optional<Duration> interval) {
  const auto covariance = monitor_.add(measured, estimator_.lastIncrement(), interval);
  report_.sensors = monitor_.report();
  if (!covariance) return Eigen::Matrix3d::Zero();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(estimator_.deadReckoned().yaw).matrix();
  estimator_.inflate(Eigen::Matrix3d(R * *covariance * R.transpose()));
  return *covariance;
}

/// Adds to the pose what the first order of doubtSteering() leaves out of a gap's motion. A path whose
/// heading changes by an unknown N(0, sigma^2) ends short of where it leads straight on, by sigma^2 / 24 of
/// its length to second order; it cannot end further off than its length.
/// @return variances (x, y, yaw) of it, along the path as the history takes it, where an error at the end is
///         shorter by chord over arc
Eigen::Vector3d OdometryPipeline::bendPath(const StepReadings& readings, const PerAxle<double>& doubt) {
  const BodyIncrement& increment = estimator_.lastIncrement();
  const SystematicSensitivity& J = increment.J_motion_systematic;
  const double turn =
      std::hypot(J(2, systematic::kFrontOffset) * doubt.front, J(2, systematic::kRearOffset) * doubt.rear);
  double length = 0.0;
  for (const double travel : readings.travel.values) length = std::max(length, std::abs(travel));
  const double shortfall = length * -std::expm1(-turn * turn / 8.0);
  const Eigen::Vector3d variances = Eigen::Vector3d(shortfall, shortfall, 0.0).cwiseAbs2();
  estimator_.inflate(Eigen::Matrix3d(variances.asDiagonal()));
  const double half_turn = 0.5 * increment.motion.z();
  const double chord = half_turn == 0.0 ? 1.0 : std::sin(half_turn) / half_turn;
  return variances / std::max(chord * chord, 1e-6);
}

/// Inside a gap the motion is as unknown as if it had not been seen, although its sum is known.
void OdometryPipeline::rememberStep(const TimeSpan& span, bool twist_known, const PerAxle<double>& doubt,
                                    const Eigen::Matrix3d& unforeseen) {
  const Eigen::Vector3d within =
      twist_known ? Eigen::Vector3d::Zero() : unseenMotion(configuration_, span.end - span.begin);
  BodyIncrement increment = estimator_.lastIncrement();
  increment.path_covariance += unforeseen;
  motion_history_.addStep(span, increment, doubt, within);
}

void OdometryPipeline::rememberUnseen(const TimeSpan& span) {
  motion_history_.addUnseen(span, unseenMotion(configuration_, span.end - span.begin).asDiagonal());
}

void OdometryPipeline::reportStep(const StepReadings& measured, const PerWheel<bool>& left_out) {
  const BodyMotion& motion = estimator_.lastIncrement().motion;
  const double path = motion.head<2>().norm();
  report_.step = motion.x() < 0.0 ? -path : path;
  report_.distance += path;
  for (const Wheel wheel : kAllWheels) report_.wheel_used[wheel] = wheel_used_[wheel] && !left_out[wheel];
  report_.wheel_travel = measured.travel;
  report_.residuals = estimator_.residuals();
  const SteeringAngles mean = measured.mean();
  report_.steering_angle = {mean.front, mean.rear};
}

PerAxle<double> OdometryPipeline::steeringReadingsAt(Time stamp) const {
  PerAxle<double> readings;
  for (const Axle axle : kAllAxles)
    if (steering_needed_[axle]) readings[axle] = steering_[axle].angleAt(stamp);
  return readings;
}

SteeringAngles OdometryPipeline::anglesOf(const PerAxle<double>& readings) const {
  const Vehicle& vehicle = configuration_.vehicle;
  const auto angle = [&](Axle axle) {
    if (!steering_needed_[axle]) return 0.0;
    const double value = vehicle.steering[axle].scale * readings[axle] + vehicle.steering[axle].offset;
    // A reading that was within the limit may be beyond it with a new scale.
    return std::clamp(value, -configuration_.limits.steering_limit, configuration_.limits.steering_limit);
  };
  SteeringAngles angles;
  angles.front = angle(Axle::kFront);
  angles.rear = vehicle.rear_steering.source == RearSteering::Source::kPolynomial
                    ? vehicle.rear_steering.angle(angles.front)
                    : angle(Axle::kRear);
  return angles;
}

/// [s] from the newest reading that is not after `stamp`; 0 where none is needed.
PerAxle<double> OdometryPipeline::steeringAges(Time stamp) const {
  PerAxle<double> ages;
  for (const Axle axle : kAllAxles) {
    if (!steering_needed_[axle]) continue;
    const std::optional<Time> newest = steering_[axle].newestUntil(stamp);
    ages[axle] = newest ? toSeconds(stamp - *newest) : 0.0;
  }
  return ages;
}

/// Standard deviation of the angles of a step [rad] beyond their noise: from max_steering_age on it grows
/// with the age of the reading until, a second old, the angle may be anywhere in its range. Inside a long
/// interval between wheel messages no instant is further than half of it from a known angle.
PerAxle<double> OdometryPipeline::steeringDoubt(double interval) const {
  constexpr double kUnknownAge = 1.0;  // [s]
  const InputLimits& limits = configuration_.limits;
  const double anywhere = limits.steering_limit / std::sqrt(3.0);  // uniform over the range
  const double trusted = toSeconds(limits.max_steering_age);
  PerAxle<double> doubt;
  for (const Axle axle : kAllAxles) {
    if (!steering_needed_[axle]) continue;
    const double in_gap = interval > toSeconds(limits.max_gap) ? 0.5 * interval : 0.0;
    const double age = std::max(report_.steering_age[axle], in_gap);
    if (age > trusted)
      doubt[axle] = anywhere * std::min((age - trusted) / std::max(kUnknownAge - trusted, 1e-3), 1.0);
  }
  return doubt;
}

OdometryUpdate OdometryPipeline::update(const WheelCounts& counts, Time completed) {
  ++counts_.wheel_messages;
  OdometryEstimate estimate = estimator_.estimate();
  const bool pose_repaired = repair(estimate.pose_covariance) || estimator_.uncertainty().repaired();
  if (repair(estimate.twist_covariance) || pose_repaired) ++counts_.covariance_repairs;
  report_.counts = counts_;
  report_.quantiles = estimator_.quantiles();
  return {counts.stamp, completed, estimate, report_, step_};
}

void OdometryPipeline::reset() {
  estimator_.reset();
  monitor_.reset();
  motion_history_.clear();
  waiting_.clear();
  reference_.reset();
  suspicious_.reset();
  jumped_before_ = PerWheel<bool>();
  report_ = StepReport();
  counts_ = InputCounts();
}

void OdometryPipeline::forgetTime() {
  for (const Axle axle : kAllAxles) steering_[axle].clear();
  waiting_.clear();
  suspicious_.reset();
  newest_wheels_.reset();
}

void OdometryPipeline::restart() {
  reset();
  forgetTime();
}

void OdometryPipeline::rebaseTime() {
  forgetTime();
  motion_history_.clear();
  reference_time_known_ = false;
}

void OdometryPipeline::setPose(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  Eigen::Matrix3d sound = 0.5 * (covariance + covariance.transpose());
  if (repair(sound)) ++counts_.covariance_repairs;
  estimator_.setPose(pose, sound);
}

OdometryCalibration OdometryPipeline::calibration() const {
  return {configuration_.vehicle.gains, configuration_.vehicle.steering,
          systematicCovariance(configuration_)};
}

void OdometryPipeline::setCalibration(const OdometryCalibration& calibration) {
  const OdometryCalibration before = this->calibration();
  configuration_.vehicle.gains = calibration.gains;
  configuration_.vehicle.steering = calibration.steering;
  configuration_.systematic_covariance = calibration.covariance;
  estimator_.setCalibration(calibration);
  monitor_.setConfiguration(configuration_);
  for (const Axle axle : kAllAxles) {
    // What a scale did to a step depends on its reading, which the history does not hold.
    if (calibration.steering[axle].scale != before.steering[axle].scale) motion_history_.clear();
  }
  motion_history_.setParameters(systematicValues(calibration) - systematicValues(before),
                                calibration.covariance);
}

}  // namespace bs_car_odometry
