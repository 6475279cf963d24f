#include "chain.hpp"

#include "bs_car_odometry/calibration/planar.hpp"
#include "bs_car_odometry/parameters/configuration.hpp"

#include <Eigen/Cholesky>

#include <optional>

namespace bs_car_odometry::calibration {

namespace {

/// Standard deviation that no motion is believed beyond, (x, y) [m] and yaw [rad]: the motion of a car at
/// rest has no noise, and would have infinite weight. A thousand links of it add up to less than 1 mm.
constexpr double kMotionFloor = 1e-5;

OdometryModel modelAt(const ParameterVector& values, Parameters parameters) {
  setValues(values, parameters);
  return makeOdometryModel(toConfiguration(parameters));
}

/// What noise/wheel adds to the covariance of a motion, c^2 sum_i d_i J_i J_i^T over the wheels of each step.
class WheelNoise {
 public:
  WheelNoise(const Parameters& parameters, const ParameterVector& values)
      : model_(modelAt(values, parameters)), variance_(parameters.noise.wheel.variance()) {}

  /// @param pose  where the step begins, in the frame of the covariance
  void extend(const StepReadings& readings, const Pose2& pose, Eigen::Matrix3d& covariance) const {
    const auto increment = std::visit([&](const auto& model) { return model.increment(readings); }, model_);
    const auto sources = std::visit([&](const auto& model) { return model.noiseSources(readings); }, model_);
    const PoseStep moved = advance(pose, increment.motion);
    const Eigen::Matrix3d F = moved.J_pose_pose();
    const Eigen::Matrix<double, 3, 4> J = moved.J_pose_motion() * sources.J_motion_wheel;
    const Eigen::Map<const Eigen::Vector4d> path(sources.wheel_path.values.data());
    covariance = F * covariance * F.transpose() + J * (variance_ * path).asDiagonal() * J.transpose();
  }

 private:
  OdometryModel model_;
  double variance_;
};

/// Goes through the steps of a drive and stops at its laser poses.
class ChainBuilder {
 public:
  ChainBuilder(const CalibrationDrive& drive, const Parameters& parameters, const ParameterVector& values,
               const std::vector<Pose2>& poses, const ChainOptions& options)
      : drive_(drive),
        values_(values),
        poses_(poses),
        options_(options),
        delay_(durationFromSeconds(values[kTimeOffset])),
        model_(parameters) {
    model_.setValues(values);
    if (options.wheel_covariance) wheel_noise_.emplace(parameters, values);
    chain_.nodes.reserve(drive.lasers().size() / options.stride + 1);
  }

  Chain build() {
    for (std::size_t i = 0; i < drive_.steps(); ++i) go(drive_.step(i));
    beginSegment();
    return std::move(chain_);
  }

 private:
  /// When the car was where the next laser pose saw it.
  Time laserTime() const { return drive_.lasers()[next_].laser.stamp - delay_; }

  void go(MeasuredStep step) {
    if (now_ != step.span.begin) {
      linked_ = false;
      beginSegment();
    }
    now_ = step.span.end;
    for (; next_ < drive_.lasers().size() && laserTime() <= *now_; ++next_) {
      if (drive_.lasers()[next_].jumped) linked_ = false;
      if (laserTime() < step.span.begin || next_ % options_.stride != 0) continue;
      if (laserTime() > step.span.begin) {
        const auto [before, after] = split(step, laserTime());
        extend(before);
        step = after;
      }
      stop(step);
    }
    if (step.span.begin < step.span.end) extend(step);
  }

  void extend(const MeasuredStep& step) {
    if (wheel_noise_) wheel_noise_->extend(model_.adapted(step.readings), segment_.motion, wheels_);
    model_.extend(step, segment_);
  }

  /// @param step  the one that comes next: its twist is that of a pose at the very beginning
  void stop(const MeasuredStep& step) {
    if (segment_.duration == 0.0 && segment_.twist.isZero(0.0)) {
      MotionSegment ahead;
      model_.extend(step, ahead);
      segment_.twist = ahead.twist;
    }
    addNode();
    beginSegment();
    linked_ = true;
  }

  void beginSegment() {
    chain_.evidence.information += segment_.evidence.information;
    chain_.evidence.gradient += segment_.evidence.gradient;
    segment_ = segment_.next();
    wheels_.setZero();
  }

  void addNode() {
    Node node;
    node.laser = next_;
    node.linked = linked_;
    node.twist = segment_.twist;
    node.link = {segment_.motion, segment_.J, segment_.covariance(), wheels_, segment_.distance, 1.0};
    node.link.noise.diagonal().array() += kMotionFloor * kMotionFloor;
    const LaserPose& laser = drive_.lasers()[next_].laser;
    node.covariance = scaled(laser.covariance, options_.laser_scales);
    setPoses(laser, node);
    chain_.nodes.push_back(node);
  }

  void setPoses(const LaserPose& laser, Node& node) const {
    node.pose = poses_[next_].vector();
    if (linked_) {
      const double expected = chain_.nodes.back().pose.z() + node.link.motion.yaw;
      node.pose.z() = expected + wrapAngle(node.pose.z() - expected);
    }
    const double seen = node.pose.z() + values_[kLaserYaw];
    node.measured = laser.pose.vector();
    node.measured.z() = seen + wrapAngle(laser.pose.yaw - seen);
  }

  const CalibrationDrive& drive_;
  const ParameterVector& values_;
  const std::vector<Pose2>& poses_;
  const ChainOptions& options_;
  Duration delay_;
  MotionModel model_;
  std::optional<WheelNoise> wheel_noise_;

  Chain chain_;
  std::size_t next_{0};      ///< laser pose
  std::optional<Time> now_;  ///< end of the last step
  bool linked_{false};       ///< the segment begins at the last node
  MotionSegment segment_;
  Eigen::Matrix3d wheels_{Eigen::Matrix3d::Zero()};
};

}  // namespace

Chain makeChain(const CalibrationDrive& drive, const Parameters& parameters, const ParameterVector& values,
                const std::vector<Pose2>& poses, const ChainOptions& options) {
  return ChainBuilder(drive, parameters, values, poses, options).build();
}

Eigen::Matrix3d scaled(const Eigen::Matrix3d& covariance, const LaserScales& scales) {
  const Eigen::Vector3d factors(scales.position, scales.position, scales.yaw);
  return factors.asDiagonal() * covariance * factors.asDiagonal();
}

Eigen::Vector3d laserResidual(const Node& node, const ParameterVector& values) {
  const Pose2 expected = Pose2{node.pose.x(), node.pose.y(), node.pose.z()} * mountOf(values);
  return node.measured - expected.vector();
}

Eigen::Vector3d motionResidual(const Node& from, const Node& to) {
  const Pose2 begin{from.pose.x(), from.pose.y(), from.pose.z()};
  const Pose2 end{to.pose.x(), to.pose.y(), to.pose.z()};
  return (inverse(begin) * end).vector() - to.link.motion.vector();
}

double normalisedSquare(const Eigen::Vector3d& residual, const Eigen::Matrix3d& R) {
  return residual.dot(R.llt().solve(residual));
}

}  // namespace bs_car_odometry::calibration
