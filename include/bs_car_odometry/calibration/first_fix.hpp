#pragma once

#include "bs_car_odometry/calibration/filter.hpp"

#include <cstddef>
#include <vector>

namespace bs_car_odometry::calibration {

struct FirstFix {
  std::size_t chosen{0};    ///< the pose that agrees with most others; of several the first
  std::size_t agreeing{0};  ///< with how many, itself among them
};

/// Chooses the pose to begin at from the first few, since nothing can reject a wrong one later on.
/// @param beginnings  where each of them puts the laser at the first stamp
FirstFix chooseFirstFix(const std::vector<LaserPose>& lasers, const std::vector<Pose2>& beginnings);

}  // namespace bs_car_odometry::calibration
