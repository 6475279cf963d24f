#pragma once

#include "bs_car_odometry/laboratory/drive.hpp"

#include <vector>

namespace bs_car_odometry::drives {

using laboratory::DriveSettings;
using laboratory::record;
using laboratory::replay;
using laboratory::Sample;

/// What the odometry says of the motion from one sample to another, which need not be among the readings that
/// it is given: each `every`-th sample from the first one on.
/// @throws std::logic_error when it says nothing
MotionEstimate motionBetween(const OdometryConfiguration& configuration, const std::vector<Sample>& drive,
                             std::size_t from, std::size_t to, std::size_t every = 1);

/// The true one.
simulation::Pose trueMotion(const std::vector<Sample>& drive, std::size_t from, std::size_t to);

/// The odometry at the end of the drive.
OdometryEstimate endOf(const OdometryConfiguration& configuration, const std::vector<Sample>& drive);

/// Distance between odometry and truth [m]: at the end of the drive, and where it is largest.
struct Departure {
  double at_end{0.0};
  double largest{0.0};
};
Departure departure(const OdometryConfiguration& configuration, const std::vector<Sample>& drive);

/// Odometry of the vehicle with these axles, everything else as by default.
OdometryConfiguration odometryOf(const Vehicle& vehicle, AxleSelection axles);

/// For the names of tests.
const char* name(AxleSelection axles);
const char* name(AxleGeometry geometry);

}  // namespace bs_car_odometry::drives
