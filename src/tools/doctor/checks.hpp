#pragma once

#include "drive_record.hpp"
#include "finding.hpp"
#include "laser_lag.hpp"
#include "motion_windows.hpp"

#include "bs_car_odometry/ros/calibration_adapter.hpp"

#include <optional>
#include <vector>

namespace bs_car_odometry::tools::doctor {

/// Each looks at one thing, and says so too when it is in order.

/// Rates, gaps, stamps and clocks of every topic.
Findings checkClocks(const DriveRecord& record);

/// Wraps, restarts and widths of the counters.
Findings checkCounters(const DriveRecord& record);

/// Frames, covariances and jumps of the laser's poses.
Findings checkLaser(const DriveRecord& record);

/// @param lag  as estimateLaserLag() gave it
Findings checkLag(const DriveRecord& record, const std::optional<LaserLag>& lag);

/// Where the laser looks, against the direction in which the wheels roll.
Findings checkLaserYaw(const DriveRecord& record, const std::vector<MotionWindow>& windows);

/// Wheels that stand still, run backwards, have the wrong size, or sit in each other's place.
/// @param source  of the windows' motion: "laser" or "steering angle"
Findings checkWheels(const DriveRecord& record, const std::vector<MotionWindow>& windows, const char* source);

/// Units, sign and life of the steering angles; without a laser only what the readings alone show.
Findings checkSteering(const DriveRecord& record, const std::vector<MotionWindow>& windows_by_laser);

/// What a calibration of this drive leaves open of each parameter, and what to drive where that is too much.
/// @param calibration  that has gone through the whole bag
Findings checkExcitation(const CalibrationAdapter& calibration);

}  // namespace bs_car_odometry::tools::doctor
