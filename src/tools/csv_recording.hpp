#pragma once

#include <bs_car_odometry/SteeringAngle.h>
#include <bs_car_odometry/WheelTicks.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>

#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// What the wheel columns of a CSV hold.
enum class WheelUnit {
  kTicks,           ///< counters
  kTickIncrements,  ///< ticks since the row before
  kMetresPerSecond,
  kRpm,  ///< turns of the wheel a minute
  kRadiansPerSecond,
};

/// @throws InputError for anything but ticks, tick_increments, m/s, rpm, rad/s
WheelUnit wheelUnit(const std::string& name);

/// True for the units that become metres by the wheel's radius.
inline bool needsRadius(WheelUnit unit) {
  return unit == WheelUnit::kRpm || unit == WheelUnit::kRadiansPerSecond;
}

/// The files of a recording and the units in them.
struct CsvSource {
  std::string wheels_file;
  std::string steering_file;  ///< empty: none
  std::string pose_file;      ///< empty: none
  WheelUnit wheel_unit{WheelUnit::kTicks};
  double wheel_radius{0.0};      ///< [m], for turning speeds
  double metres_per_tick{1e-5};  ///< [m], of the counters that speeds become
  double radians_per_unit{1.0};  ///< [rad], of the steering reading
  double steering_ratio{1.0};    ///< reading / angle of the axle
};

/// The recording as this package's messages, each kind in time order.
struct Recording {
  std::vector<WheelTicks> wheels;
  std::vector<SteeringAngle> front_steering;
  std::vector<SteeringAngle> rear_steering;
  std::vector<geometry_msgs::PoseWithCovarianceStamped> laser_poses;
  std::vector<nav_msgs::Odometry> ground_truth;
};

/// Reads the files. Recordings that begin before 1e6 s are moved by 1.6e9 s, all files by the same amount,
/// since stamp zero is no time.
/// @throws InputError, a sentence with file and line
Recording readRecording(const CsvSource& source);

}  // namespace bs_car_odometry::tools
