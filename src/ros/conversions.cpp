#include "bs_car_odometry/ros/conversions.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>

namespace bs_car_odometry {

namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1000000000;

/// Where x, y and yaw stand in the six of a message.
constexpr std::array<std::size_t, 3> kPlanar{0, 1, 5};

}  // namespace

std::optional<Time> toTime(const ros::Time& stamp) {
  if (stamp.nsec >= kNanosecondsPerSecond) return std::nullopt;
  return timeFromNanoseconds(static_cast<std::int64_t>(stamp.sec) * kNanosecondsPerSecond + stamp.nsec);
}

ros::Time toRos(Time time) {
  constexpr std::int64_t kEnd =
      static_cast<std::int64_t>(std::numeric_limits<std::uint32_t>::max()) * kNanosecondsPerSecond +
      (kNanosecondsPerSecond - 1);
  const std::int64_t nanoseconds = std::clamp<std::int64_t>(time.time_since_epoch().count(), 0, kEnd);
  return ros::Time(static_cast<std::uint32_t>(nanoseconds / kNanosecondsPerSecond),
                   static_cast<std::uint32_t>(nanoseconds % kNanosecondsPerSecond));
}

geometry_msgs::Quaternion toQuaternion(double yaw) {
  geometry_msgs::Quaternion quaternion;
  const double half = 0.5 * wrapAngle(yaw);
  quaternion.z = std::sin(half);
  quaternion.w = std::cos(half);
  return quaternion;
}

std::optional<double> toYaw(const geometry_msgs::Quaternion& q) {
  const double norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  if (!(norm > 0.9 && norm < 1.1)) return std::nullopt;
  return std::atan2(2.0 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z);
}

boost::array<double, 36> toCovariance(const Eigen::Matrix3d& covariance, double unmeasured_variance) {
  boost::array<double, 36> message{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      message[6 * kPlanar[i] + kPlanar[j]] =
          covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  for (const std::size_t unmeasured : {2, 3, 4}) message[7 * unmeasured] = unmeasured_variance;
  return message;
}

Eigen::Matrix3d toPlanarCovariance(const boost::array<double, 36>& message) {
  Eigen::Matrix3d covariance;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          0.5 * (message[6 * kPlanar[i] + kPlanar[j]] + message[6 * kPlanar[j] + kPlanar[i]]);
  return covariance;
}

bool isCovariance(const Eigen::Matrix3d& matrix) {
  if (!matrix.allFinite()) return false;
  const Eigen::Vector3d eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  return eigenvalues.minCoeff() >= -1e-9 * std::max(eigenvalues.maxCoeff(), 0.0);
}

std::optional<Pose2> toPose(const geometry_msgs::Pose& message) {
  const std::optional<double> yaw = toYaw(message.orientation);
  if (!yaw) return std::nullopt;
  const Pose2 pose{message.position.x, message.position.y, *yaw};
  if (!pose.isFinite()) return std::nullopt;
  return pose;
}

void fillOdometry(const OdometryUpdate& update, const OutputFrames& frames, nav_msgs::Odometry& message) {
  const OdometryEstimate& estimate = update.estimate;
  message.header.stamp = toRos(update.stamp);
  message.header.frame_id = frames.odom;
  message.child_frame_id = frames.base;
  message.pose.pose.position.x = estimate.pose.x;
  message.pose.pose.position.y = estimate.pose.y;
  message.pose.pose.orientation = toQuaternion(estimate.pose.yaw);
  message.pose.covariance = toCovariance(estimate.pose_covariance, frames.unmeasured_variance);
  message.twist.twist.linear.x = estimate.twist.x();
  message.twist.twist.linear.y = estimate.twist.y();
  message.twist.twist.angular.z = estimate.twist.z();
  message.twist.covariance = toCovariance(estimate.twist_covariance, frames.unmeasured_variance);
}

void fillParticles(const OdometryUpdate& update, const PoseUncertainty& uncertainty,
                   const OutputFrames& frames, std::size_t most, geometry_msgs::PoseArray& message) {
  message.header.stamp = toRos(update.stamp);
  message.header.frame_id = frames.odom;
  message.poses.resize(std::min(most, uncertainty.particles()));
  for (std::size_t i = 0; i < message.poses.size(); ++i) {
    const Pose2 pose = uncertainty.particle(i * uncertainty.particles() / message.poses.size());
    message.poses[i].position.x = pose.x;
    message.poses[i].position.y = pose.y;
    message.poses[i].orientation = toQuaternion(pose.yaw);
  }
}

void fillTransform(const OdometryUpdate& update, const OutputFrames& frames,
                   geometry_msgs::TransformStamped& message) {
  message.header.stamp = toRos(update.stamp);
  message.header.frame_id = frames.odom;
  message.child_frame_id = frames.base;
  message.transform.translation.x = update.estimate.pose.x;
  message.transform.translation.y = update.estimate.pose.y;
  message.transform.rotation = toQuaternion(update.estimate.pose.yaw);
}

}  // namespace bs_car_odometry
