#pragma once

#include "bs_car_odometry/core/se2.hpp"
#include "bs_car_odometry/core/time.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace bs_car_odometry::tools::doctor {

/// What the laser's poses are like, pose by pose.
class LaserWatch {
 public:
  explicit LaserWatch(const LaserSigma& laser_sigma) : laser_sigma_(laser_sigma) {}

  /// @return the pose, yaw not wrapped; none when it is none
  std::optional<Pose2> add(const geometry_msgs::PoseWithCovarianceStamped& message, Time stamp);

  std::uint64_t notPoses() const { return not_poses_; }  ///< not finite, or a quaternion that is none
  std::uint64_t withoutCovariance() const { return without_covariance_; }  ///< laser_sigma holds for them
  std::uint64_t badCovariances() const { return bad_covariances_; }  ///< the calibration drops these poses
  const std::set<std::string>& frames() const { return frames_; }    ///< of the headers; at most kMostFrames
  std::uint64_t jumps() const { return jumps_; }                     ///< of the localiser
  Time jumpAt() const { return jump_at_; }                           ///< the largest
  /// Of the first kMostJumps.
  const std::vector<Time>& jumpTimes() const { return jump_times_; }
  double largestJump() const { return largest_jump_; }  ///< [m]
  double largestTurn() const { return largest_turn_; }  ///< [rad]

  static constexpr std::size_t kMostFrames = 8;
  static constexpr std::size_t kMostJumps = 1000;

 private:
  void noteFrame(const std::string& frame);
  void noteCovariance(const geometry_msgs::PoseWithCovarianceStamped& message);
  void noteMotion(const Pose2& pose, Time stamp);
  bool isJump(const Eigen::Vector3d& strange, double dt) const;
  void noteJump(const Eigen::Vector3d& jump, Time stamp);

  LaserSigma laser_sigma_;
  std::uint64_t not_poses_{0}, without_covariance_{0}, bad_covariances_{0}, jumps_{0};
  std::set<std::string> frames_;
  double sigma_{0.0};  ///< [m] as the last covariance says
  std::optional<Pose2> last_;
  Time last_stamp_;
  Eigen::Vector3d velocity_{Eigen::Vector3d::Zero()};  ///< [m/s, m/s, rad/s] in the map
  int followed_{0};                                    ///< poses since the last jump
  double largest_jump_{0.0}, largest_turn_{0.0};
  Time jump_at_;
  std::vector<Time> jump_times_;
};

}  // namespace bs_car_odometry::tools::doctor
