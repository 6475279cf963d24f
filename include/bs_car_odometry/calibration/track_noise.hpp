#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/se2.hpp"

#include <Eigen/Core>

#include <array>
#include <cstddef>

namespace bs_car_odometry::calibration {

/// The columns of the two tracks go with the measured turn and have its noise: what this has in common with
/// the noise of the motion, and with itself, would look as if a straight line showed a track
/// (docs/calibration.md, C14).
struct TrackNoise {
  /// Of a step whose turn is increment.motion.z().
  void add(const BodyIncrement& increment, const Eigen::Matrix3d& G);
  static constexpr std::array<std::size_t, kAxles> kTracks{systematic::kFrontTrack, systematic::kRearTrack};

  PerAxle<Eigen::Matrix3d> with_motion{Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
  /// Covariance of a track's column.
  PerAxle<Eigen::Matrix3d> own{Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};

  /// All of it under a linear map of motion and columns.
  void transform(const Eigen::Matrix3d& A);
  TrackNoise& operator+=(const TrackNoise& other);
};

}  // namespace bs_car_odometry::calibration
