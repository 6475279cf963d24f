#pragma once

#include "drive_record.hpp"

#include "bs_car_odometry/core/kinematics.hpp"
#include "bs_car_odometry/core/se2.hpp"

#include <string>
#include <vector>

namespace bs_car_odometry::tools::doctor {

/// A stretch of the drive, about as long as the car or a sixth of a right angle: how the body moved, and what
/// the sensors read meanwhile.
struct MotionWindow {
  double begin;  ///< [s]
  double end;    ///< [s]
  BodyMotion motion;
  PerWheel<double> travel;  ///< [m]
  PerAxle<double> angle;    ///< [rad] mean of the axle's readings, where it is read
};

/// Windows whose motion is that of the laser. @param lag  [s] by which the laser's stamps are late
std::vector<MotionWindow> windowsByLaser(const DriveRecord& record, double lag);

/// Windows whose motion is that of the steering angles, as far as the wheels have rolled: where there is no
/// laser. Empty where no axle is read.
std::vector<MotionWindow> windowsBySteering(const DriveRecord& record);

/// What the wheels have rolled from `begin` to `end` [s]. @return false when the record does not hold it
bool travelBetween(const DriveRecord& record, double begin, double end, PerWheel<double>& travel);

/// Steering angles with the rear axle's by its law.
SteeringAngles anglesOf(const Vehicle& vehicle, const PerAxle<double>& read);

}  // namespace bs_car_odometry::tools::doctor
