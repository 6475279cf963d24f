#include "bs_car_odometry/ros/laser_input.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <tf2/buffer_core.h>
#include <tf2/exceptions.h>
#include <Eigen/Eigenvalues>

#include <cmath>
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
constexpr std::size_t kMostFrames = 1000;       // tf keeps every frame that was ever named
constexpr std::size_t kLongestName = 256;       // characters
constexpr double kUnitTolerance = 0.0099;       // of a quaternion's squared norm; tf has 0.01
constexpr double kFarthestMount = 100.0;        // m, as laser/x and laser/y

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

bool isName(const std::string& frame) { return !frame.empty() && frame.size() <= kLongestName; }

/// tf refuses what is not, too, but with a line in the log for each.
bool isLink(const geometry_msgs::TransformStamped& link) {
  const std::string parent = withoutSlash(link.header.frame_id);
  const std::string child = withoutSlash(link.child_frame_id);
  const auto& t = link.transform.translation;
  const auto& q = link.transform.rotation;
  const double norm = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  return isName(parent) && isName(child) && parent != child && std::isfinite(t.x) && std::isfinite(t.y) &&
         std::isfinite(t.z) && std::abs(norm - 1.0) <= kUnitTolerance;
}

}  // namespace

LaserMountFinder::LaserMountFinder(const std::string& base_frame, const std::string& laser_frame)
    : base_frame_(withoutSlash(base_frame)),
      laser_frame_(withoutSlash(laser_frame)),
      buffer_(std::make_unique<tf2::BufferCore>()) {}

LaserMountFinder::~LaserMountFinder() = default;

/// Mounts do not move, so that every link is a static one: their stamps do not matter, which tf's arithmetic
/// cannot bear at the end of their range and which it complains of, in the log, when they are old.
void LaserMountFinder::add(const tf2_msgs::TFMessage& message) {
  if (mount_) return;
  for (const geometry_msgs::TransformStamped& link : message.transforms)
    if (isLink(link) && hasRoomFor(link.header.frame_id) && hasRoomFor(link.child_frame_id))
      buffer_->setTransform(link, kAuthority, true);
  mount_ = find();
}

/// True for the frames that came first.
bool LaserMountFinder::hasRoomFor(const std::string& frame) {
  if (frames_.size() < kMostFrames) frames_.insert(frame);
  return frames_.count(frame) > 0;
}

std::optional<Pose2> LaserMountFinder::find() const {
  try {
    const geometry_msgs::Transform found =
        buffer_->lookupTransform(base_frame_, laser_frame_, ros::Time()).transform;
    geometry_msgs::Pose pose;
    pose.position.x = found.translation.x;
    pose.position.y = found.translation.y;
    pose.orientation = found.rotation;
    const std::optional<Pose2> mount = toPose(pose);
    return mount && mount->position().norm() <= kFarthestMount ? mount : std::nullopt;
  } catch (const tf2::TransformException&) {
    return std::nullopt;  // Not yet: the frames may come in pieces.
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
