#include "bs_car_odometry/ros/laser_input.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <tf2/buffer_core.h>
#include <tf2/exceptions.h>
#include <Eigen/Eigenvalues>

#include <stdexcept>
#include <utility>

namespace bs_car_odometry {

using calibration::LaserPose;
using calibration::LaserVerdict;

namespace {

constexpr double kLargestVariance = 1e12;  // m^2; beyond, products of variances leave a double's range
constexpr double kSmallestVariance =
    1e-14;                         // m^2, rad^2; below, a second pose at the same place is no number
constexpr double kFarthest = 1e9;  // m, as far as a pose may be anywhere else in the package
constexpr double kSmallestEigenvalue = 1e-9;    // of the correlation matrix
constexpr const char* kAuthority = "recorded";  // tf wants to know whose transforms these are

std::string withoutSlash(const std::string& frame) {
  return !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
}

/// The correlation matrix, so that metres and radians count alike.
bool isPositiveDefinite(const Eigen::Matrix3d& matrix) {
  if (!(matrix.diagonal().minCoeff() >= kSmallestVariance)) return false;
  const Eigen::Vector3d scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix3d correlation = scale.asDiagonal() * matrix * scale.asDiagonal();
  if (!correlation.allFinite()) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(correlation, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() >= kSmallestEigenvalue;
}

/// Stamps at the end of their range make tf's arithmetic throw.
void setTransform(tf2::BufferCore& buffer, const geometry_msgs::TransformStamped& transform, bool is_static) {
  try {
    buffer.setTransform(transform, kAuthority, is_static);
  } catch (const std::runtime_error&) {
    // As good as absent.
  }
}

}  // namespace

LaserMountFinder::LaserMountFinder(const std::string& base_frame, const std::string& laser_frame)
    : base_frame_(withoutSlash(base_frame)),
      laser_frame_(withoutSlash(laser_frame)),
      buffer_(std::make_unique<tf2::BufferCore>()) {}

LaserMountFinder::~LaserMountFinder() = default;

void LaserMountFinder::add(const tf2_msgs::TFMessage& message, bool is_static) {
  if (mount_) return;
  for (const geometry_msgs::TransformStamped& transform : message.transforms)
    setTransform(*buffer_, transform, is_static);
  try {
    const geometry_msgs::Transform found =
        buffer_->lookupTransform(base_frame_, laser_frame_, ros::Time()).transform;
    geometry_msgs::Pose pose;
    pose.position.x = found.translation.x;
    pose.position.y = found.translation.y;
    pose.orientation = found.rotation;
    mount_ = toPose(pose);
  } catch (const tf2::TransformException&) {
    // Not yet: the frames may come in pieces.
  }
}

bool lacksCovariance(const boost::array<double, 36>& message) {
  const Eigen::Matrix3d covariance = toPlanarCovariance(message);
  return covariance.topLeftCorner<2, 2>().isZero(0.0) || covariance(2, 2) == 0.0;
}

std::optional<Eigen::Matrix3d> laserCovariance(const boost::array<double, 36>& message,
                                               const LaserSigma& sigma) {
  Eigen::Matrix3d covariance = toPlanarCovariance(message);
  if (!covariance.allFinite() || covariance.cwiseAbs().maxCoeff() > kLargestVariance) return std::nullopt;
  if (covariance.topLeftCorner<2, 2>().isZero(0.0))
    covariance.topLeftCorner<2, 2>().diagonal().setConstant(sigma.position * sigma.position);
  if (covariance(2, 2) == 0.0) covariance(2, 2) = sigma.yaw * sigma.yaw;
  if (!isPositiveDefinite(covariance)) return std::nullopt;
  return covariance;
}

LaserPoseReader::LaserPoseReader(const Parameters& parameters)
    : stamp_source_(parameters.stamp_source),
      max_future_(parameters.limits.max_future),
      sigma_(parameters.laser_sigma) {}

void LaserPoseReader::forgetMap() {
  map_known_ = false;
  map_frame_.clear();
}

std::variant<LaserPose, LaserVerdict> LaserPoseReader::read(
    const geometry_msgs::PoseWithCovarianceStamped& message, const ros::Time& receipt) {
  LaserPose laser;
  const LaserVerdict verdict = check(message, receipt, laser);
  if (verdict != LaserVerdict::kAccepted) return verdict;
  if (!map_known_) map_frame_ = withoutSlash(message.header.frame_id);
  map_known_ = true;
  return laser;
}

LaserVerdict LaserPoseReader::check(const geometry_msgs::PoseWithCovarianceStamped& message,
                                    const ros::Time& receipt, LaserPose& laser) const {
  const std::optional<Time> received = toTime(receipt);
  const std::optional<Time> stamp =
      stamp_source_ == StampSource::kReceipt ? received : toTime(message.header.stamp);
  if (!stamp) return LaserVerdict::kStampInvalid;
  if (*stamp == Time()) return LaserVerdict::kStampZero;
  if (*stamp > received.value_or(Time()) + max_future_) return LaserVerdict::kFuture;
  if (map_known_ && withoutSlash(message.header.frame_id) != map_frame_) return LaserVerdict::kOtherFrame;
  const std::optional<Pose2> pose = toPose(message.pose.pose);
  if (!pose || !(pose->position().cwiseAbs().maxCoeff() <= kFarthest)) return LaserVerdict::kNotFinite;
  const std::optional<Eigen::Matrix3d> covariance = laserCovariance(message.pose.covariance, sigma_);
  if (!covariance) return LaserVerdict::kBadCovariance;
  laser = {*stamp, *pose, *covariance};
  return LaserVerdict::kAccepted;
}

}  // namespace bs_car_odometry
