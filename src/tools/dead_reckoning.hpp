#pragma once

#include "bs_car_odometry/calibration/calibration_drive.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"

#include <cstddef>
#include <vector>

namespace bs_car_odometry::tools {

/// Where the car was at a laser pose, by the laser and by dead reckoning.
struct ReckonedPose {
  std::size_t laser;  ///< its number in the drive
  Pose2 measured;     ///< base_link in the map, from the laser pose and the laser's mount
  Pose2 reckoned;     ///< base_link in the map
  bool begins;        ///< dead reckoning starts here, at the measured pose
  double distance;    ///< [m] since the drive's first one, without what was not seen
};

/// Dead reckoning over a drive with given values of the parameters, from its first good laser pose on. Where
/// the localiser has jumped or motion was not seen it begins anew.
/// @param parameters  those that the drive was recorded with
/// @param good        for each laser pose; others are passed over
std::vector<ReckonedPose> deadReckon(const calibration::CalibrationDrive& drive, const Parameters& parameters,
                                     const calibration::ParameterVector& values,
                                     const std::vector<bool>& good);

/// How far dead reckoning ends from the laser; the ends of parts add up.
struct EndDrift {
  double distance{0.0};  ///< [m]
  double error{0.0};     ///< [m]
  double percent() const { return distance > 0.0 ? 100.0 * error / distance : 0.0; }
};

EndDrift endDriftOf(const std::vector<ReckonedPose>& path);

}  // namespace bs_car_odometry::tools
