#include "laser_watch.hpp"

#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/laser_input.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::tools::doctor {

namespace {

/// A pose has jumped when neither noise nor a car's acceleration explains how far it is from where the last
/// ones were going.
constexpr double kJump = 0.3;            // [m]
constexpr double kTurnJump = 0.15;       // [rad]
constexpr double kAcceleration = 10.0;   // [m/s^2]
constexpr double kTurnAcceleration = 5;  // [rad/s^2], of a small robot
constexpr double kSmoothing = 0.2;       // [s] of the velocity
constexpr int kPosesForVelocity = 5;

}  // namespace

std::optional<Pose2> LaserWatch::add(const geometry_msgs::PoseWithCovarianceStamped& message, Time stamp) {
  noteFrame(message.header.frame_id);
  std::optional<Pose2> pose = toPose(message.pose.pose);
  if (!pose) {
    ++not_poses_;
    return std::nullopt;
  }
  noteCovariance(message);
  if (last_) pose->yaw = last_->yaw + wrapAngle(pose->yaw - last_->yaw);
  noteMotion(*pose, stamp);
  return pose;
}

void LaserWatch::noteFrame(const std::string& frame) {
  if (frames_.size() < kMostFrames) frames_.insert(frame.substr(0, 64));
}

void LaserWatch::noteCovariance(const geometry_msgs::PoseWithCovarianceStamped& message) {
  if (lacksCovariance(message.pose.covariance)) ++without_covariance_;
  const std::optional<Eigen::Matrix3d> covariance = laserCovariance(message.pose.covariance, laser_sigma_);
  if (covariance) {
    sigma_ = std::sqrt(covariance->topLeftCorner<2, 2>().trace());
  } else {
    ++bad_covariances_;
  }
}

/// A pose against where the ones before were going.
void LaserWatch::noteMotion(const Pose2& pose, Time stamp) {
  const double dt = last_ ? toSeconds(stamp - last_stamp_) : 0.0;
  if (dt > 0.0) {
    const Eigen::Vector3d step = pose.vector() - last_->vector();
    const Eigen::Vector3d strange = step - velocity_ * dt;
    if (isJump(strange, dt)) {
      if (followed_ >= kPosesForVelocity)
        noteJump(strange, stamp);
      else
        velocity_ = step / dt;
      followed_ = 0;
    } else {
      velocity_ += std::min(1.0, dt / kSmoothing) * (step / dt - velocity_);
      ++followed_;
    }
  }
  last_ = pose;
  last_stamp_ = stamp;
}

bool LaserWatch::isJump(const Eigen::Vector3d& strange, double dt) const {
  const double slack = dt * std::max(dt, kSmoothing);
  return strange.head<2>().norm() > kJump + kAcceleration * slack + 6.0 * sigma_ ||
         std::abs(strange.z()) > kTurnJump + kTurnAcceleration * slack;
}

void LaserWatch::noteJump(const Eigen::Vector3d& jump, Time stamp) {
  ++jumps_;
  if (jump_times_.size() < kMostJumps) jump_times_.push_back(stamp);
  const double distance = jump.head<2>().norm();
  if (distance >= largest_jump_) jump_at_ = stamp;
  largest_jump_ = std::max(largest_jump_, distance);
  largest_turn_ = std::max(largest_turn_, std::abs(jump.z()));
}

}  // namespace bs_car_odometry::tools::doctor
