#include "bs_car_odometry/core/fault_monitor.hpp"

#include "bs_car_odometry/core/systematic_prior.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace bs_car_odometry {

namespace {

constexpr double kStepAlarm = 100.0;      // chi-square of a step that is worth a closer look
constexpr double kStretch = 0.1;          // [s]
constexpr double kSteeringRate = 0.5;     // [rad/s], how fast an angle that nobody measures may change
constexpr int kSoundStretches = 5;        // in succession, until one is taken back or known to be swapped
constexpr double kSoundFall = 9.0;        // of chi-square: 3 standard deviations
constexpr double kSeparable = 5.0;        // standard deviations between sound and the fault that was found
constexpr double kSwapAlarm = 50.0;       // chi-square that no single sensor explains
constexpr double kSwapExplained = 0.5;    // of what the likeliest single sensor leaves of chi-square
constexpr double kSoundChiSquare = 16.3;  // 3 degrees of freedom, 0.1 %
constexpr double kMostDeviation = 1.0;
constexpr int kLongSteady = 10;      // stretches: a noisy wheel repeats itself now and then, and not as often
constexpr double kStuckRatio = 0.2;  // measured over expected travel, about 0
constexpr double kReversedRatio = -0.5;

/// [rad] standard deviation of an angle that may be anywhere in its range.
double anywhere(const InputLimits& limits) { return limits.steering_limit / std::sqrt(3.0); }

ParameterEvidence noEvidence() {
  return {SystematicCovariance::Zero(), ParameterEvidence::Gradient::Zero(), 0.0};
}

void add(const ParameterEvidence& evidence, ParameterEvidence& sum) {
  sum.information += evidence.information;
  sum.gradient += evidence.gradient;
  sum.chi_square += evidence.chi_square;
}

/// [m] that the car goes, if a wheel of it may be wrong: the median of what those say that are not left out.
double lengthOf(const StepReadings& readings) {
  std::array<double, kWheels> travels;
  travels.fill(std::numeric_limits<double>::infinity());
  std::size_t count = 0;
  for (const Wheel wheel : kAllWheels)
    if (!readings.left_out[wheel]) travels[count++] = std::abs(readings.travel[wheel]);
  if (count == 0) return 0.0;
  std::sort(travels.begin(), travels.end());
  return 0.5 * (travels[(count - 1) / 2] + travels[count / 2]);
}

/// [rad] of an angle; 0 for a wheel, whose travel tells nothing of whether it has stopped.
double readingOf(std::size_t sensor, const StepReadings& readings) {
  return isWheel(sensor) ? 0.0 : readings.mean()[static_cast<Axle>(sensor - kWheels)];
}

SensorFault faultOf(double ratio) {
  if (std::abs(ratio) < kStuckRatio) return SensorFault::kStuck;
  return ratio < kReversedRatio ? SensorFault::kReversed : SensorFault::kWrongTravel;
}

}  // namespace

FaultMonitor::FaultMonitor(const OdometryConfiguration& configuration)
    : configuration_(configuration),
      prior_(systematicCovariance(configuration)),
      fit_(configuration.vehicle, configuration.noise),
      steady_(configuration.vehicle),
      all_wheels_(configuration.options.axles == AxleSelection::kBoth),
      enabled_(all_wheels_ && configuration.options.fault_detection),
      follows_law_(configuration.vehicle.rear_steering.source == RearSteering::Source::kPolynomial) {
  for (const Wheel wheel : kAllWheels) present_[sensor(wheel)] = configuration.vehicle.hasEncoder(wheel);
  present_[sensor(Axle::kFront)] = true;
  present_[sensor(Axle::kRear)] = !follows_law_;
}

void FaultMonitor::reset() {
  out_.reset();
  undecided_.reset();
  likeliest_.reset();
  swapped_.reset();
  frozen_.reset();
  steady_.reset();
  report_ = SensorReport();
  course_ = PerAxle<Course>();
  swap_votes_ = {};
  reconsidered_ = {};
  needed_suspect_.reset();
  guesses_ = 0;
  startStretch();
  window_.count = 0;
}

void FaultMonitor::setConfiguration(const OdometryConfiguration& configuration) {
  configuration_ = configuration;
  prior_ = systematicCovariance(configuration);
  fit_ = WheelFit(configuration.vehicle, configuration.noise);
  steady_.setVehicle(configuration.vehicle);
  startStretch();
  window_.count = 0;
}

// --- what a step may use ---------------------------------------------------------------------------------

StepReadings FaultMonitor::without(const SensorSet& out, const StepReadings& measured) const {
  const double unknown = anywhere(configuration_.limits);
  StepReadings readings = measured;
  for (const Wheel wheel : kAllWheels)
    readings.left_out[wheel] = measured.left_out[wheel] || out[sensor(wheel)];
  for (const Axle axle : kAllAxles) {
    if (!present_[sensor(axle)] || !(out[sensor(axle)] || measured.steering_doubt[axle] > 0.0)) continue;
    if (out[sensor(axle)]) readings.steering_doubt[axle] = unknown;
    const double angle = course_[axle].angle;
    for (SteeringAngles* angles : {&readings.begin, &readings.end}) {
      (axle == Axle::kFront ? angles->front : angles->rear) = angle;
      if (follows_law_) angles->rear = configuration_.vehicle.rear_steering.angle(angle);
    }
  }
  return readings;
}

/// The rest must tell how far, whereto and how the car turns: two angles and a wheel; one angle and wheels on
/// both sides; or such wheels and the law between two unknown angles.
bool FaultMonitor::determines(const SensorSet& out) const {
  const SensorSet rest = present_ & ~out;
  const auto has = [&](Wheel wheel) { return rest[sensor(wheel)]; };
  const bool left = has(Wheel::kFrontLeft) || has(Wheel::kRearLeft);
  const bool right = has(Wheel::kFrontRight) || has(Wheel::kRearRight);
  const bool front = rest[sensor(Axle::kFront)];
  const bool rear =
      follows_law_ ? front || configuration_.vehicle.rear_steering.isConstant() : rest[sensor(Axle::kRear)];
  if (front && rear) return left || right;
  return left && right && (front || rear || follows_law_);
}

/// When most counters jump, none was wrong: the driver was restarted.
bool FaultMonitor::canDoWithout(const PerWheel<bool>& wheels) const {
  SensorSet jumped;
  SensorSet read;
  for (const Wheel wheel : kAllWheels) {
    jumped[sensor(wheel)] = wheels[wheel];
    read[sensor(wheel)] = present_[sensor(wheel)];
  }
  return all_wheels_ && 2 * jumped.count() <= read.count() && determines(out_ | jumped);
}

/// How many equations are left over when the motion is known.
int FaultMonitor::spareEquations(const SensorSet& out) const {
  const SensorSet rest = present_ & ~out;
  int equations = 0;
  for (const Wheel wheel : kAllWheels) equations += rest[sensor(wheel)] ? 1 : 0;
  for (const Axle axle : kAllAxles) equations += rest[sensor(axle)] ? 1 : 0;
  return equations + (follows_law_ ? 1 : 0) - 3;
}

/// All suspects; the likeliest when the motion were not known without all of them.
bool FaultMonitor::leaveOut(const Suspects& suspects, const SensorTests& tests) {
  SensorSet all;
  for (std::size_t i = 0; i < suspects.count; ++i) all.set(suspects.sensors[i]);
  const bool spared = determines(out_ | all);
  if (!spared) all = SensorSet().set(suspects.sensors[0]);
  all &= present_ & ~out_;
  if (suspects.count == 0 || all.none()) return false;
  report_.determined = determines(out_ | all);
  if (!report_.determined) return false;
  out_ |= all;
  if (all.count() > 1) undecided_ |= all;
  if (!spared) likeliest_ |= all;
  for (std::size_t i = 0; i < kSensors; ++i) {
    if (!all[i]) continue;
    inspections_[i] = {noEvidence(), std::min(std::abs(tests.sensors[i].deviation), kMostDeviation), 0, 0.0};
    report_.sensors[i] = SensorState();
    report_.sensors[i].fault = SensorFault::kUndecided;
  }
  ++report_.exclusions;
  startStretch();
  window_.count = 0;
  return true;
}

// --- gross faults, within a step -------------------------------------------------------------------------

bool FaultMonitor::contradicts(const StepReadings& readings, const FitResiduals& residuals) {
  if (!enabled_ || !(residuals.chi_square > kStepAlarm)) return false;
  const SensorTests tests = testSensors(fit_.evidence(readings), prior_);
  const Suspects found = blame(tests, readings, lengthOf(readings));
  if (!leaveOut(found, tests)) return false;
  describe(found, tests, readings);
  return true;
}

// --- small ones, over a stretch --------------------------------------------------------------------------

void FaultMonitor::Window::add(const ParameterEvidence& newest, double length) {
  if (count == kStretches) {
    std::move(evidence.begin() + 1, evidence.end(), evidence.begin());
    std::move(lengths.begin() + 1, lengths.end(), lengths.begin());
  }
  count = std::min(count + 1, kStretches);
  evidence[count - 1] = newest;
  lengths[count - 1] = length;
}

double FaultMonitor::Window::sumOfLengths() const {
  return std::accumulate(lengths.begin(), lengths.begin() + static_cast<std::ptrdiff_t>(count), 0.0);
}

ParameterEvidence FaultMonitor::Window::sum() const {
  ParameterEvidence sum = noEvidence();
  for (std::size_t i = 0; i < count; ++i) bs_car_odometry::add(evidence[i], sum);
  return sum;
}

std::optional<Eigen::Matrix3d> FaultMonitor::add(const StepReadings& measured, const BodyIncrement& increment,
                                                 std::optional<Duration> interval) {
  if (!all_wheels_) return std::nullopt;
  const double seconds = toSeconds(interval.value_or(configuration_.limits.max_gap));
  follow(increment, seconds);
  if (!enabled_) return std::nullopt;
  for (std::size_t i = 0; i < kSensors; ++i)
    if (out_[i]) report_.sensors[i].duration += seconds;
  if (!interval || measured.leavesOut() || measured.isDoubted() || measured_.isReversedBy(measured)) {
    startStretch();
    return std::nullopt;
  }
  measured_.add(measured);
  elapsed_ += seconds;
  if (measured_.length() == 0.0) startStretch();  // with the motion, not with the standstill before it
  if (elapsed_ < kStretch) return std::nullopt;
  const StepReadings stretch = measured_.readings();
  const double length = measured_.length();
  const double duration = elapsed_;
  startStretch();
  steady_.add(stretch, duration);
  followFrozen(stretch, duration);
  inspectSensors(stretch);
  BodyMotion effect = judge(stretch);
  if (effect.isZero(0.0)) effect = judgeFrozen(stretch);
  const Eigen::Matrix3d covariance = effect * effect.transpose() + guess(length);
  if (covariance.isZero(0.0)) return std::nullopt;
  return covariance;
}

void FaultMonitor::startStretch() {
  measured_ = PendingReadings();
  elapsed_ = 0.0;
}

/// The angle of an axle by the motion of the car, through a filter: a short step knows little of it.
void FaultMonitor::follow(const BodyIncrement& increment, double interval) {
  const BodyMotion& t = increment.motion;
  for (const Axle axle : kAllAxles) {
    Course& course = course_[axle];
    course.variance += std::pow(kSteeringRate * interval, 2);
    const double a = configuration_.vehicle.axleX(axle);
    const Eigen::Vector2d velocity(t.x(), t.y() + a * t.z());
    if (velocity.x() == 0.0) continue;
    const double angle = std::atan(velocity.y() / velocity.x());
    const Eigen::Vector3d across(-std::sin(angle), std::cos(angle), a * std::cos(angle));
    const double variance = across.dot(increment.step_covariance * across) / velocity.squaredNorm();
    const double gain = course.variance / (course.variance + std::max(variance, 0.0));
    const double limit = configuration_.limits.steering_limit;
    course.angle = std::clamp(course.angle + gain * (angle - course.angle), -limit, limit);
    course.variance *= 1.0 - gain;
  }
}

/// The suspects, or a pair of wheels that have each other's counters when that explains more.
Suspects FaultMonitor::blame(const SensorTests& tests, const StepReadings& readings, double length) const {
  Suspects found = suspects(tests, length);
  if (found.count == 0 && tests.chi_square < kSwapAlarm) return found;
  double least = found.count > 0 ? tests.chi_square - tests.sensors[found.sensors[0]].fall
                                 : kSwapExplained * tests.chi_square;
  least *= kSwapExplained;
  for (std::size_t a = 0; a < kWheels; ++a)
    for (std::size_t b = a + 1; b < kWheels; ++b) {
      const SensorSet pair = SensorSet().set(a).set(b);
      if ((pair & present_ & ~out_) != pair) continue;
      const double chi_square = chiSquareSwapped(a, b, readings);
      if (chi_square > least) continue;
      least = chi_square;
      found.sensors[0] = a;
      found.sensors[1] = b;
      found.count = 2;
    }
  return found;
}

/// @return what a fault that has been found has done to the motion
BodyMotion FaultMonitor::judge(const StepReadings& stretch) {
  if (needed_suspect_ && determines(out_ | SensorSet().set(*needed_suspect_))) needed_suspect_.reset();
  report_.determined = !needed_suspect_;
  const StepReadings readings = trusted(stretch);
  const double length = lengthOf(readings);
  window_.add(fit_.evidence(readings), length);
  SensorTests tests = testSensors(window_.newest(), prior_);
  Suspects found = blame(tests, readings, length);
  const bool found_at_once = found.count > 0;
  if (!found_at_once) {
    tests = testSensors(window_.sum(), prior_);
    found = suspects(tests, window_.sumOfLengths());
  }
  if (found.count == 0) return BodyMotion::Zero();
  // A wheel's fault is found in the stretch that it begins in; an angle's may have grown over the window.
  const bool at_once = found_at_once && isWheel(found.sensors[0]);
  const double stretches = at_once ? 1.0 : static_cast<double>(window_.count);
  reconsider(found.sensors[0], stretch);
  if (!leaveOut(found, tests)) {
    if (!report_.determined) needed_suspect_ = found.sensors[0];
    return BodyMotion::Zero();
  }
  describe(found, tests, stretch);
  return stretches * (fit_.increment(trusted(stretch)).motion - fit_.increment(readings).motion);
}

/// Which wheels are frozen; one that begins to read something else is so no longer.
void FaultMonitor::followFrozen(const StepReadings& stretch, double seconds) {
  PerWheel<bool> ignored;
  for (const Wheel wheel : kAllWheels) ignored[wheel] = out_[sensor(wheel)];
  for (const Wheel wheel : kAllWheels) {
    if (steady_.run(wheel).stretches == 1) frozen_.reset(sensor(wheel));
    if (steady_.isLeftBehind(wheel, stretch, seconds, ignored) && isFrozen(wheel, stretch, seconds))
      frozen_.set(sensor(wheel));
  }
}

/// The wheel's reading has stayed the same for a second; by the others, its speed has not.
bool FaultMonitor::isFrozen(Wheel wheel, const StepReadings& stretch, double seconds) const {
  const SteadyWheels::Run& run = steady_.run(wheel);
  const SensorSet out = out_ | SensorSet().set(sensor(wheel));
  if (run.stretches < kLongSteady || !present_[sensor(wheel)] || !determines(out)) return false;
  // Of an angle that is left out, nobody knows what it was when the run began.
  if (out_[sensor(Axle::kFront)] || out_[sensor(Axle::kRear)]) return false;
  const double change = speedOf(wheel, stretch, seconds) - speedOf(wheel, run.first, run.seconds);
  return std::abs(change) > steady_.leastChange(wheel, stretch, seconds);
}

/// [m/s] of a wheel by the others.
double FaultMonitor::speedOf(Wheel wheel, const StepReadings& stretch, double seconds) const {
  const StepReadings others = without(out_ | SensorSet().set(sensor(wheel)), stretch);
  return (stretch.travel[wheel] - fit_.increment(others).residuals.wheel[wheel]) / seconds;
}

/// A driver that repeats the last speed of a silent sensor is nearly right as long as the car keeps it: no
/// test of how well the readings agree sees it early.
/// @return what it has done to the pose, all of its run taken as one arc
BodyMotion FaultMonitor::judgeFrozen(const StepReadings& stretch) {
  for (const Wheel wheel : kAllWheels) {
    if (!frozen_[sensor(wheel)] || out_[sensor(wheel)]) continue;
    const StepReadings run = steady_.run(wheel).all.readings();
    const BodyMotion with = fit_.increment(trusted(run)).motion;
    const Suspects found{{sensor(wheel)}, 1};
    const SensorTests tests = testSensors(fit_.evidence(trusted(stretch)), prior_);
    if (!leaveOut(found, tests)) continue;
    describe(found, tests, stretch);
    return log(inverse(exp(with)) * exp(fit_.increment(trusted(run)).motion));
  }
  return BodyMotion::Zero();
}

/// Where a suspect is needed, another may have been left out in its place: one that makes sense with the rest
/// once the suspect is gone. One that was left out for itself, and not for one of several, makes sense in
/// passing, too: it must do so for longer.
void FaultMonitor::reconsider(std::size_t suspect, const StepReadings& stretch) {
  if (determines(out_ | SensorSet().set(suspect))) return;
  for (std::size_t i = 0; i < kSensors; ++i) {
    Reconsidered& innocent = reconsidered_[i];
    if (!makesSenseWithout(suspect, i, stretch)) {
      innocent = Reconsidered();
      continue;
    }
    const double angle = readingOf(i, stretch);
    if (innocent.stretches == 0 || innocent.suspect != suspect) innocent = {suspect, 0, angle};
    const bool moved = isWheel(i) || std::abs(angle - innocent.first_angle) > 2.0 * leastFault(i);
    const bool long_enough = ++innocent.stretches >= kSoundStretches && moved;
    if (!long_enough && !likeliest_[i] && !undecided_[i]) continue;
    reconsidered_ = {};
    return takeBack(i);
  }
}

/// @param innocent  one that is left out, and would be used instead
bool FaultMonitor::makesSenseWithout(std::size_t suspect, std::size_t innocent,
                                     const StepReadings& stretch) const {
  SensorSet out = out_ | SensorSet().set(suspect);
  const bool possible = out_[innocent] && innocent != suspect && !swapped_[innocent] && !frozen_[innocent];
  return possible && determines(out.reset(innocent)) && makesSense(without(out, stretch));
}

/// The readings agree with each other, and on a motion that the car can make.
bool FaultMonitor::makesSense(const StepReadings& readings) const {
  if (testSensors(fit_.evidence(readings), prior_).chi_square > kSoundChiSquare) return false;
  const BodyMotion motion = fit_.increment(readings).motion;
  for (const Axle axle : kAllAxles) {
    const double sideways = motion.y() + configuration_.vehicle.axleX(axle) * motion.z();
    if (std::abs(std::atan2(sideways, std::abs(motion.x()))) > configuration_.limits.steering_limit)
      return false;
  }
  return true;
}

/// Covariance of a stretch of which nothing confirms that the right sensors are left out: the car may have
/// steered anywhere. The error is the same in all such stretches, so that n of them have n^2 of it.
Eigen::Matrix3d FaultMonitor::guess(double length) {
  const bool is_undecided = (out_ & undecided_).count() > 1 || (out_ & likeliest_).any();
  const bool is_guess = !report_.determined || (is_undecided && spareEquations(out_) < 1);
  guesses_ = is_guess ? guesses_ + 1 : 0;
  if (!is_guess) return Eigen::Matrix3d::Zero();
  const double sideways = length * std::tan(anywhere(configuration_.limits));
  const Eigen::Vector3d error(length, sideways, 2.0 * sideways / configuration_.vehicle.wheelbase);
  return (2.0 * guesses_ - 1.0) * error.array().square().matrix().asDiagonal().toDenseMatrix();
}

// --- sensors that are left out ---------------------------------------------------------------------------

void FaultMonitor::inspectSensors(const StepReadings& measured) {
  for (std::size_t i = 0; i < kSensors; ++i)
    if (out_[i]) inspect(i, measured);
  inspectSwaps(measured);
}

/// With what it was found by, or as little as is a fault, the evidence must tell sound from faulty.
void FaultMonitor::inspect(std::size_t sensor, const StepReadings& measured) {
  SensorSet others = out_;
  others.reset(sensor);
  Inspection& inspection = inspections_[sensor];
  bs_car_odometry::add(fit_.evidence(without(others, measured)), inspection.evidence);
  const SensorTest test = testSensors(inspection.evidence, prior_).sensors[sensor];
  describe(sensor, measured, test);
  if (test.sigma * kSeparable > std::max(inspection.found, 2.0 * leastFault(sensor))) return;
  const bool sound = test.fall < kSoundFall || std::abs(test.deviation) < 0.5 * leastFault(sensor);
  const double angle = readingOf(sensor, measured);
  if (!sound || inspection.sound == 0) inspection.first_angle = angle;
  inspection.sound = sound ? inspection.sound + 1 : 0;
  inspection.evidence = noEvidence();
  // What is frozen is right in passing.
  const bool moved = isWheel(sensor) ? !frozen_[sensor]
                                     : std::abs(angle - inspection.first_angle) > 2.0 * leastFault(sensor);
  if (inspection.sound >= kSoundStretches && moved && !swapped_[sensor]) takeBack(sensor);
}

void FaultMonitor::takeBack(std::size_t sensor) {
  out_.reset(sensor);
  likeliest_.reset(sensor);
  frozen_.reset(sensor);
  report_.sensors[sensor] = SensorState();
  window_.count = 0;
}

void FaultMonitor::describe(const Suspects& suspects, const SensorTests& tests,
                            const StepReadings& measured) {
  for (std::size_t i = 0; i < suspects.count; ++i)
    describe(suspects.sensors[i], measured, tests.sensors[suspects.sensors[i]]);
}

void FaultMonitor::describe(std::size_t sensor, const StepReadings& measured, const SensorTest& test) {
  SensorState& state = report_.sensors[sensor];
  if (!out_[sensor] || swapped_[sensor]) return;
  undecided_ &= out_;
  const bool undecided = (undecided_[sensor] && undecided_.count() > 1) || likeliest_[sensor];
  if (!isWheel(sensor)) {
    state.angle_error = -test.deviation;
    state.fault = undecided ? SensorFault::kUndecided : SensorFault::kWrongAngle;
    return;
  }
  const double travel = measured.travel.values[sensor];
  const double expected = travel - fit_.increment(trusted(measured)).residuals.wheel.values[sensor];
  if (expected == 0.0) return;
  state.ratio = travel / expected;
  state.fault = undecided ? SensorFault::kUndecided : faultOf(state.ratio);
  if (frozen_[sensor] && travel != 0.0 && !undecided) state.fault = SensorFault::kFrozen;
}

/// Two wheels that make sense with each other's counters, and not with their own.
void FaultMonitor::inspectSwaps(const StepReadings& measured) {
  for (std::size_t a = 0; a < kWheels; ++a)
    for (std::size_t b = a + 1; b < kWheels; ++b) {
      if (!out_[a] || !out_[b] || swapped_[a] || swapped_[b]) continue;
      int& votes = swap_votes_[a][b];
      votes = isSwapped(a, b, measured) ? votes + 1 : 0;
      if (votes < kSoundStretches) continue;
      for (const std::size_t k : {a, b}) {
        swapped_.set(k);
        report_.sensors[k].fault = SensorFault::kSwapped;
      }
    }
}

bool FaultMonitor::isSwapped(std::size_t a, std::size_t b, const StepReadings& measured) const {
  SensorSet others = out_;
  const StepReadings readings = without(others.reset(a).reset(b), measured);
  return testSensors(fit_.evidence(readings), prior_).chi_square > kStepAlarm &&
         chiSquareSwapped(a, b, readings) < kSoundChiSquare;
}

double FaultMonitor::chiSquareSwapped(std::size_t a, std::size_t b, StepReadings readings) const {
  std::swap(readings.travel.values[a], readings.travel.values[b]);
  return testSensors(fit_.evidence(readings), prior_).chi_square;
}

}  // namespace bs_car_odometry
