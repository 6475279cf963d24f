#pragma once

#include "bs_car_odometry/CalibrationState.h"
#include "bs_car_odometry/calibration/calibrator.hpp"
#include "bs_car_odometry/calibration/dead_reckoning.hpp"
#include "bs_car_odometry/calibration/result.hpp"

#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>

#include <string>
#include <vector>

namespace bs_car_odometry {

/// State of a calibration as a message, all but header, vehicle and vehicle_checksum, which do not change.
void fillCalibrationState(const calibration::Calibrator& calibrator, CalibrationMethod method,
                          CalibrationState& message);

/// @param map_frame   of the pose
/// @param base_frame  of the twist
void fillOdometry(const calibration::DeadReckonedPose& pose, const std::string& map_frame,
                  const std::string& base_frame, double unmeasured_variance, nav_msgs::Odometry& message);

nav_msgs::Path toPath(const std::vector<Pose2>& poses, const std_msgs::Header& header);

/// What a calibration has found so far, for a file: the observed parameters.
calibration::CalibrationResult resultOf(const calibration::Calibrator& calibrator);

}  // namespace bs_car_odometry
