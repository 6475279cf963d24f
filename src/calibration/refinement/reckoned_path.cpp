#include "reckoned_path.hpp"

#include <Eigen/Geometry>

namespace bs_car_odometry::calibration {

namespace {

/// What a rotation about the origin moves a point by, per radian.
Eigen::Vector2d turned(const Eigen::Vector2d& point) { return {-point.y(), point.x()}; }

class PathBuilder {
 public:
  PathBuilder(const ParameterVector& values, const TrustedPoses& trusted)
      : trusted_(trusted), mount_{values[kLaserX], values[kLaserY], values[kLaserYaw]} {}

  std::vector<PathPoint> build(const Chain& chain) {
    for (const Node& node : chain.nodes) {
      begun_ = begun_ && node.linked;
      if (begun_)
        move(node);
      else if (trusted_[node.laser])
        begin(node);
    }
    return std::move(points_);
  }

 private:
  void begin(const Node& node) {
    const Pose2 laser{node.measured.x(), node.measured.y(), node.measured.z()};
    begin_ = laser * inverse(mount_);
    origin_ = laser.position();
    begin_twist_ = node.twist;
    S_.setZero();
    begun_ = true;
    points_.push_back(point(node, begin_));
    points_.back().begins = true;
  }

  void move(const Node& node) {
    const Pose2 before = points_.back().base;
    const Pose2 base = before * node.link.motion;
    const Eigen::Matrix3d T = rotation(before.yaw);
    S_.topRows<2>() += turned(base.position() - before.position()) * S_.row(2);
    S_ += T * node.link.J;
    PathPoint next = point(node, base);
    next.noise = T * node.link.noise * T.transpose();
    setSensitivity(node, next);
    points_.push_back(next);
  }

  PathPoint point(const Node& node, const Pose2& base) const {
    PathPoint point;
    point.laser = node.laser;
    point.begins = false;
    point.trusted = trusted_[node.laser];
    point.base = base;
    point.reckoned = (base * mount_).position();
    point.measured = node.measured.head<2>();
    point.J.setZero();
    point.R = node.covariance;
    point.noise.setZero();
    return point;
  }

  /// With the laser's yaw all of the path turns about its beginning; with the delay it begins and ends later.
  void setSensitivity(const Node& node, PathPoint& point) const {
    const Eigen::Vector2d arm = point.reckoned - point.base.position();
    point.J.leftCols<kMotionCount>() = S_.topRows<2>() + turned(arm) * S_.row(2);
    const Eigen::Matrix3d turn = rotation(point.base.yaw) - rotation(begin_.yaw);
    point.J.middleCols<2>(kLaserX) = turn.topLeftCorner<2, 2>();
    point.J.col(kLaserYaw) = -turned(point.reckoned - origin_);
    point.J.col(kTimeOffset) =
        velocity(begin_twist_, begin_, point.reckoned) - velocity(node.twist, point.base, point.reckoned);
  }

  /// Of a point that is fixed to base_link [m/s], in the map's axes.
  static Eigen::Vector2d velocity(const BodyMotion& twist, const Pose2& base, const Eigen::Vector2d& point) {
    return rotation(base.yaw).topLeftCorner<2, 2>() * twist.head<2>() +
           twist.z() * turned(point - base.position());
  }

  static Eigen::Matrix3d rotation(double yaw) {
    return Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }

  const TrustedPoses& trusted_;
  Pose2 mount_;
  std::vector<PathPoint> points_;
  bool begun_{false};
  Pose2 begin_;             ///< base_link where dead reckoning starts
  Eigen::Vector2d origin_;  ///< the laser's point there
  BodyMotion begin_twist_;
  MotionSensitivity S_;  ///< d base / d parameters that move the car, in the map's axes
};

}  // namespace

TrustedPoses trustedPoses(const CalibrationDrive& drive, const std::vector<LaserResidual>& residuals) {
  TrustedPoses trusted(drive.lasers().size(), true);
  for (const LaserResidual& residual : residuals)
    trusted[residual.laser] = !drive.lasers()[residual.laser].rejected || residual.square <= kRejectLimit;
  return trusted;
}

std::vector<PathPoint> reckonPath(const Chain& chain, const ParameterVector& values,
                                  const TrustedPoses& trusted) {
  return PathBuilder(values, trusted).build(chain);
}

}  // namespace bs_car_odometry::calibration
