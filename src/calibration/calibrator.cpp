#include "bs_car_odometry/calibration/calibrator.hpp"

#include "bs_car_odometry/calibration/first_fix.hpp"
#include "bs_car_odometry/calibration/motion_model.hpp"
#include "bs_car_odometry/calibration/planar.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <utility>

namespace bs_car_odometry::calibration {

namespace {

constexpr std::size_t kMostLasers = 1024;  ///< waiting for wheels: 2 s at 500 Hz
constexpr std::size_t kMostSteps = 8192;   ///< waiting for lasers: 2 s at 4 kHz

/// The beginning is chosen from so many poses, or from more until some of them agree.
constexpr std::size_t kFewestFixes = 5;
constexpr std::size_t kMostFixes = 20;
constexpr std::size_t kFewestAgreeing = 3;

/// A localiser that has jumped is believed after so many poses that agree with each other (row C4).
constexpr int kPosesOfJump = 10;

/// A pose whose moment the filter has just passed is still taken, by its velocity: the time offset moves by
/// milliseconds from pose to pose.
constexpr Duration kLongestLead = std::chrono::milliseconds(20);

bool isPositiveDefinite(const Eigen::Matrix3d& covariance) {
  return covariance.allFinite() && covariance.llt().info() == Eigen::Success;
}

}  // namespace

Calibrator::Calibrator(const Parameters& parameters)
    : parameters_(parameters),
      estimated_(parametersToEstimate(parameters)),
      prior_(priorDeviations(parameters)),
      filter_(makeFilter(parameters)) {}

void Calibrator::start() {
  filter_ = makeFilter(parameters_);
  newDrive();
  ever_begun_ = false;
  innovation_ = Innovation();
  counts_ = LaserCounts();
  excitation_ = Excitation();
  span_.reset();
}

void Calibrator::newDrive() {
  forgetPose();
  forgetTime();
}

std::optional<CalibrationMemory> Calibrator::memory() const {
  const FilterEstimate estimate = filter_->estimate();
  if (!span_ || !filter_->clone()->restore(estimate.values, estimate.covariance)) return std::nullopt;
  return CalibrationMemory{estimate.values, estimate.covariance, excitation_, counts_, *span_};
}

bool Calibrator::resume(const CalibrationMemory& memory) {
  if (!filter_->restore(memory.values, memory.covariance)) return false;
  excitation_ = memory.driven;
  counts_ = memory.counts;
  span_ = memory.span;
  ever_begun_ = true;
  return true;
}

void Calibrator::forgetPose() {
  begun_ = false;
  fixes_.clear();
  since_fix_.clear();
  rehearsal_.reset();
  before_jump_.reset();
  candidate_.reset();
}

void Calibrator::forgetTime() {
  steps_.clear();
  lasers_.clear();
  now_.reset();
  newest_laser_.reset();
}

void Calibrator::add(const OdometryUpdate& update) {
  const std::optional<Time> reached = steps_.empty() ? now_ : std::optional<Time>(steps_.back().span.end);
  if (!update.step) {
    // A first message, or one after a time that is not known: nothing leads here from where the filter is.
    forgetPose();
    if (reached && update.stamp < *reached) forgetTime();
    steps_.clear();
    now_ = update.stamp;
    return;
  }
  if (reached && update.step->span.begin != *reached) {
    forgetPose();
    steps_.clear();
    now_ = update.step->span.begin;
  }
  if (!now_) now_ = update.step->span.begin;
  steps_.push_back(*update.step);
  if (begun_ && update.report.interval > 0.0) excitation_.add(update.estimate.twist * update.report.interval);
  process();
}

LaserVerdict Calibrator::add(const LaserPose& laser) {
  const auto verdict = [&] {
    if (!laser.pose.isFinite()) return LaserVerdict::kNotFinite;
    if (!isPositiveDefinite(laser.covariance)) return LaserVerdict::kBadCovariance;
    if (newest_laser_ && laser.stamp <= *newest_laser_) return LaserVerdict::kOutOfOrder;
    if (now_ && effectiveTime(laser) < *now_ - kLongestLead) return LaserVerdict::kTooLate;
    if (lasers_.size() >= kMostLasers) return LaserVerdict::kOverflow;
    return LaserVerdict::kAccepted;
  }();
  if (verdict != LaserVerdict::kAccepted) {
    ++counts_.dropped;
    return verdict;
  }
  newest_laser_ = laser.stamp;
  lasers_.push_back(laser);
  process();
  return verdict;
}

/// When the car was where the laser saw it.
Time Calibrator::effectiveTime(const LaserPose& laser) const {
  return laser.stamp - durationFromSeconds(filter_->timeOffset());
}

/// Takes every pose whose moment the steps have reached.
void Calibrator::process() {
  while (!lasers_.empty() && now_) {
    const Time time = effectiveTime(lasers_.front());
    if (time > (steps_.empty() ? *now_ : steps_.back().span.end)) break;
    const LaserPose laser = lasers_.front();
    lasers_.pop_front();
    if (time < *now_ - kLongestLead) {
      ++counts_.dropped;
      continue;
    }
    moveTo(time);
    take(laser);
  }
  consumeOldSteps();
}

/// Steps that no pose will come for any more.
void Calibrator::consumeOldSteps() {
  while (!steps_.empty() &&
         (steps_.size() > kMostSteps || steps_.front().span.end < steps_.back().span.end - kLongestDelay)) {
    move(steps_.front());
    steps_.pop_front();
  }
}

void Calibrator::moveTo(Time time) {
  while (!steps_.empty() && steps_.front().span.end <= time) {
    move(steps_.front());
    steps_.pop_front();
  }
  if (steps_.empty() || time <= steps_.front().span.begin) return;
  const auto [before, after] = split(steps_.front(), time);
  move(before);
  steps_.front() = after;
}

void Calibrator::move(const MeasuredStep& step) {
  now_ = step.span.end;
  if (begun_) {
    filter_->move(step);
    if (rehearsal_) rehearsal_->add(step);
    if (before_jump_) before_jump_->move(step);
    if (candidate_) candidate_->move(step);
    return;
  }
  // Before the first fix only the velocity matters; between fixes that never come, nothing does.
  if (fixes_.empty() || since_fix_.size() >= kMostSteps) {
    fixes_.clear();
    since_fix_.clear();
  }
  since_fix_.push_back(step);
}

void Calibrator::take(const LaserPose& laser) {
  if (begun_) {
    update(laser);
  } else {
    collectFix(laser);
  }
}

void Calibrator::collectFix(const LaserPose& laser) {
  // At an unknown speed a pose says nothing of the delay, and would seem to say all.
  if (estimated_[kTimeOffset] && fixes_.empty() && since_fix_.empty()) return;
  fixes_.push_back({laser, std::move(since_fix_)});
  since_fix_.clear();
  if (fixes_.size() < kFewestFixes) return;
  const MotionModel model(parameters_);
  MotionSegment segment;
  std::vector<LaserPose> lasers;
  std::vector<Pose2> motions;
  std::vector<Pose2> beginnings;
  const Pose2 mount = mountOf(parameters_.laser);
  for (const Fix& fix : fixes_) {
    if (!lasers.empty())
      for (const MeasuredStep& step : fix.steps) model.extend(step, segment);
    lasers.push_back(fix.laser);
    motions.push_back(inverse(mount) * segment.motion * mount);
    beginnings.push_back(fix.laser.pose * inverse(motions.back()));
  }
  const FirstFix first = chooseFirstFix(lasers, beginnings);
  if (first.agreeing >= kFewestAgreeing || fixes_.size() >= kMostFixes) begin(first.chosen, motions);
}

/// Begins where the chosen pose puts the car at the first stamp, and takes the others from there.
/// @param motions  of the laser since the first stamp
void Calibrator::begin(std::size_t chosen, const std::vector<Pose2>& motions) {
  const std::vector<Fix> fixes = std::move(fixes_);
  forgetPose();
  LaserPose first = fixes[chosen].laser;
  first.stamp = fixes.front().laser.stamp;
  first.pose = first.pose * inverse(motions[chosen]);
  for (const MeasuredStep& step : fixes.front().steps) filter_->move(step);
  now_ = effectiveTime(first);
  filter_->begin(first);
  // The moments of the poses move with the time offset, and would not be those of the steps any more.
  if (!estimated_[kTimeOffset]) rehearsal_.emplace(*filter_);
  begun_ = ever_begun_ = true;
  if (!span_) span_ = TimeSpan{first.stamp, first.stamp};
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    if (i > 0)
      for (const MeasuredStep& step : fixes[i].steps) move(step);
    if (i != chosen) update(fixes[i].laser);
  }
}

void Calibrator::update(const LaserPose& laser) {
  const double lead = std::min(0.0, toSeconds(effectiveTime(laser) - *now_));
  std::unique_ptr<Filter> before = before_jump_ ? nullptr : filter_->clone();
  innovation_ = filter_->update(laser, lead);
  if (rehearsal_) rehearsal_->add(laser, lead);
  ++counts_.used;
  std::optional<LocaliserJump> jump;
  if (innovation_.nis > kRejectLimit) {
    ++counts_.rejected;
    jump = watchForJump(laser, lead, std::move(before));
  } else {
    before_jump_.reset();
    candidate_.reset();
    rehearse();
  }
  if (span_) span_->end = laser.stamp;
  report(laser, jump);
}

/// Rejected poses that agree with each other are a new beginning of the map, not outliers.
std::optional<LocaliserJump> Calibrator::watchForJump(const LaserPose& laser, double lead,
                                                      std::unique_ptr<Filter> before) {
  if (before) before_jump_ = std::move(before);
  if (candidate_ && candidate_->update(laser, lead).nis <= kRejectLimit) {
    if (++agreeing_ >= kPosesOfJump) return adoptCandidate();
    return std::nullopt;
  }
  candidate_ = before_jump_->clone();
  candidate_->begin(laser);
  candidate_begin_ = laser.stamp;
  agreeing_ = 1;
  return std::nullopt;
}

LocaliserJump Calibrator::adoptCandidate() {
  const Pose2 expected = before_jump_->estimate().pose;
  filter_ = std::move(candidate_);
  const Pose2 found = filter_->estimate().pose;
  rehearsal_.reset();
  before_jump_.reset();
  ++counts_.relocalisations;
  return {candidate_begin_, (found.position() - expected.position()).norm(),
          wrapAngle(found.yaw - expected.yaw)};
}

void Calibrator::rehearse() {
  if (!rehearsal_) return;
  if (rehearsal_->isDue())
    if (std::unique_ptr<Filter> again = rehearsal_->repeat(filter_->estimate().values))
      filter_ = std::move(again);
  if (rehearsal_->isOver()) rehearsal_.reset();
}

void Calibrator::report(const LaserPose& laser, const std::optional<LocaliserJump>& jump) {
  if (listener_)
    listener_({laser.stamp, *now_, laser, innovation_, filter_->estimate(), excitation_.distance, jump});
}

ParameterMask Calibrator::observed() const {
  const ParameterMatrix covariance = filter_->estimate().covariance;
  ParameterMask observed{};
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    observed[i] = estimated_[i] && std::sqrt(covariance(k, k)) < 0.5 * prior_[k];
  }
  return observed;
}

bool Calibrator::allGainsObserved() const {
  const ParameterMask observed = this->observed();
  for (std::size_t i = 0; i < kCount; ++i)
    if (isGain(i) && estimated_[i] && !observed[i]) return false;
  return true;
}

CalibrationStage Calibrator::stage() const {
  if (!ever_begun_) return CalibrationStage::kStart;
  return allGainsObserved() ? CalibrationStage::kConverged : CalibrationStage::kRunning;
}

}  // namespace bs_car_odometry::calibration
