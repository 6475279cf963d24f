#pragma once

#include "bs_car_odometry/laboratory/consistency.hpp"

#include <cstddef>
#include <vector>

namespace bs_car_odometry::drives {

/// Part of a drive, by the numbers of its samples.
struct Interval {
  std::size_t from{0};
  std::size_t to{0};
  std::size_t every{1};  ///< the odometry is given each so many-th sample
};

/// Judges the motion in a part of each drive, in the axes of base_link at its beginning.
/// @return one for each odometry
std::vector<laboratory::Consistency> studyMotions(const laboratory::StudySettings& settings,
                                                  const Interval& interval);

}  // namespace bs_car_odometry::drives
