#pragma once

#include "bs_car_odometry/calibration/calibrator.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/time.h>
#include <tf2_msgs/TFMessage.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>

namespace tf2 {
class BufferCore;
}

namespace bs_car_odometry {

/// Where the laser sits, from tf. Mounts do not move: the first answer holds.
class LaserMountFinder {
 public:
  LaserMountFinder(const std::string& base_frame, const std::string& laser_frame);
  ~LaserMountFinder();
  LaserMountFinder(const LaserMountFinder&) = delete;
  LaserMountFinder& operator=(const LaserMountFinder&) = delete;

  /// A message of /tf or /tf_static. Links with numbers or names that are none are as good as absent, and so
  /// are those of frames beyond the thousandth.
  void add(const tf2_msgs::TFMessage& message);

  /// Pose of the laser's frame in the base frame; none until tf connects them, within 100 m.
  const std::optional<Pose2>& mount() const { return mount_; }

 private:
  bool hasRoomFor(const std::string& frame);
  std::optional<Pose2> find() const;

  std::string base_frame_;
  std::string laser_frame_;
  std::set<std::string> frames_;  ///< that the buffer may hold
  std::unique_ptr<tf2::BufferCore> buffer_;
  std::optional<Pose2> mount_;
};

/// Covariance (x, y, yaw) that a laser pose is taken with: its own, and `sigma` in the place of a position or
/// a yaw that has none (all zero).
/// @return none when it is not finite, not positive definite, below (0.1 micrometres)^2 or beyond (1000 km)^2
std::optional<Eigen::Matrix3d> laserCovariance(const boost::array<double, 36>& message,
                                               const LaserSigma& sigma);

/// True where laserCovariance() has to step in.
bool lacksCovariance(const boost::array<double, 36>& message);

/// From messages to laser poses: checks stamp, frame, pose and covariance.
class LaserPoseReader {
 public:
  explicit LaserPoseReader(const Parameters& parameters);

  /// @param receipt  the clock live, the record time in a bag
  std::variant<calibration::LaserPose, calibration::LaserVerdict> read(
      const geometry_msgs::PoseWithCovarianceStamped& message, const ros::Time& receipt);

  /// The map's name, from the first pose that was good; empty before.
  const std::string& mapFrame() const { return map_frame_; }
  /// The next pose may be in another map.
  void forgetMap();

 private:
  calibration::LaserVerdict check(const geometry_msgs::PoseWithCovarianceStamped& message,
                                  const ros::Time& receipt, calibration::LaserPose& laser) const;

  StampSource stamp_source_;
  Duration max_future_;
  LaserSigma sigma_;
  std::string map_frame_;
  bool map_known_{false};
};

}  // namespace bs_car_odometry
