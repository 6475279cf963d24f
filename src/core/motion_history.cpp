#include "bs_car_odometry/core/motion_history.hpp"

#include "bs_car_odometry/core/steering_doubt.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

/// Steps one after the other, propagated as OdometryEstimator does, from zero.
class MotionAccumulation {
 public:
  explicit MotionAccumulation(const SystematicRoot& systematic_root) : systematic_root_(systematic_root) {}

  /// @param part  of the step that counts, in (0, 1]: travel, noise and sensitivity are in its proportion
  void add(const MotionHistory::Step& step, double part) {
    const SystematicSensitivity J = part * step.J_motion_systematic;
    const PoseStep moved = advance(pose_, part * step.motion);
    covariance_.advance(moved, part * step.path_covariance, systematic_root_(J));
    // Nothing is open at the ends of a step, most in its middle.
    if (part < 1.0) covariance_.inflate((part * (1.0 - part) * step.within).asDiagonal());
    // What was not seen neither adds to a doubt of the steering nor ends it.
    if (step.seen) addDoubt(moved, J, step.steering_doubt);
    pose_ = moved.pose;
    distance_ += part * step.motion.head<2>().norm();
    if (!step.seen) unseen_ += part * toSeconds(step.span.end - step.span.begin);
  }

  MotionEstimate result() const {
    return {pose_, covariance_.total() + doubt_.share(), distance_, durationFromSeconds(unseen_)};
  }

 private:
  void addDoubt(const PoseStep& moved, const SystematicSensitivity& J, const PerAxle<double>& sigma) {
    const bool doubt = sigma.front > 0.0 || sigma.rear > 0.0;
    if (!doubt && !doubt_.isActive()) return;
    doubt_.advance(moved, J, sigma);
    if (doubt) return;
    // Trusted again: what the doubt has done stays, and the next one is a new error.
    covariance_.inflate(doubt_.share());
    doubt_.reset();
  }

  const SystematicRoot& systematic_root_;
  Pose2 pose_;
  FirstOrderCovariance covariance_{Eigen::Matrix3d::Zero()};
  SteeringDoubt doubt_;
  double distance_{0.0};
  double unseen_{0.0};  ///< [s]
};

MotionEstimate inverse(const MotionEstimate& motion) {
  const double c = std::cos(motion.motion.yaw);
  const double s = std::sin(motion.motion.yaw);
  MotionEstimate result = motion;
  result.motion = inverse(motion.motion);
  Eigen::Matrix3d J;  // of the inverse with respect to (x, y, yaw)
  J << -c, -s, result.motion.y, s, -c, -result.motion.x, 0.0, 0.0, -1.0;
  const Eigen::Matrix3d covariance = J * motion.covariance * J.transpose();
  result.covariance = 0.5 * (covariance + covariance.transpose());
  return result;
}

MotionHistory::MotionHistory(Duration longest, const SystematicCovariance& systematic, std::size_t most_steps)
    : longest_(longest),
      systematic_root_(systematic),
      capacity_(longest > Duration::zero() ? std::max<std::size_t>(most_steps, 1) : 0) {
  steps_.reserve(capacity_);
}

void MotionHistory::addStep(const TimeSpan& span, const BodyIncrement& increment,
                            const PerAxle<double>& steering_doubt, const Eigen::Vector3d& within) {
  Step* step = append(span);
  if (step == nullptr) return;
  step->motion = increment.motion;
  step->path_covariance = increment.path_covariance;
  step->J_motion_systematic = increment.J_motion_systematic;
  step->steering_doubt = steering_doubt;
  step->within = within;
  step->seen = true;
}

void MotionHistory::addUnseen(const TimeSpan& span, const Eigen::Matrix3d& covariance) {
  BodyIncrement stays;
  stays.path_covariance = covariance;
  addStep(span, stays, {}, Eigen::Vector3d::Zero());
  if (size_ > 0) steps_[place(size_ - 1)].seen = false;
}

/// Room for a step after the newest one, at the cost of the oldest; none when nothing is kept.
MotionHistory::Step* MotionHistory::append(const TimeSpan& span) {
  if (capacity_ == 0) return nullptr;
  if (size_ > 0 && step(size_ - 1).span.end != span.begin) clear();
  while (size_ > 0 && span.end - step(0).span.end >= longest_) dropOldest();
  if (size_ == capacity_) dropOldest();
  const std::size_t newest = place(size_++);
  if (newest == steps_.size()) steps_.emplace_back();
  steps_[newest].span = span;
  return &steps_[newest];
}

void MotionHistory::setParameters(const Eigen::Matrix<double, systematic::kCount, 1>& change,
                                  const SystematicCovariance& systematic) {
  systematic_root_ = SystematicRoot(systematic);
  for (Step& step : steps_) step.motion += step.J_motion_systematic * change;
}

void MotionHistory::dropOldest() {
  oldest_ = place(1);
  --size_;
}

void MotionHistory::clear() {
  oldest_ = 0;
  size_ = 0;
}

std::optional<TimeSpan> MotionHistory::span() const {
  if (size_ == 0) return std::nullopt;
  return TimeSpan{step(0).span.begin, step(size_ - 1).span.end};
}

std::size_t MotionHistory::firstEndingAfter(Time stamp) const {
  std::size_t low = 0;
  std::size_t high = size_;
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (step(middle).span.end <= stamp) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

std::optional<MotionEstimate> MotionHistory::between(Time from, Time to) const {
  const std::optional<TimeSpan> known = span();
  if (!known || !known->contains(from) || !known->contains(to)) return std::nullopt;
  const MotionEstimate motion = to < from ? inverse(accumulate(to, from)) : accumulate(from, to);
  if (!motion.motion.isFinite() || !motion.covariance.allFinite()) return std::nullopt;
  return motion;
}

MotionEstimate MotionHistory::accumulate(Time from, Time to) const {
  MotionAccumulation accumulation(systematic_root_);
  for (std::size_t i = firstEndingAfter(from); i < size_ && step(i).span.begin < to; ++i) {
    const TimeSpan& span = step(i).span;
    const Duration asked = std::min(span.end, to) - std::max(span.begin, from);
    accumulation.add(step(i), toSeconds(asked) / toSeconds(span.end - span.begin));
  }
  return accumulation.result();
}

}  // namespace bs_car_odometry
