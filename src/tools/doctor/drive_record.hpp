#pragma once

#include "counter_watch.hpp"
#include "laser_watch.hpp"
#include "series.hpp"
#include "stamp_statistics.hpp"

#include "bs_car_odometry/core/odometry_configuration.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"

#include <limits>
#include <optional>
#include <vector>

namespace bs_car_odometry::tools::doctor {

/// [m] that the wheels have rolled since the start, as configured.
struct WheelSample {
  double t;
  PerWheel<double> travel;
};

struct AngleSample {
  double t;
  double angle;  ///< [rad] after scale and offset
};

/// base_link in the map, by the laser; the laser itself while its mount is not known.
struct LaserSample {
  double t;
  Pose2 base;
};

/// Readings of one axle's steering.
struct SteeringWatch {
  explicit SteeringWatch(const InputLimits& limits) : clock(limits) {}

  StampStatistics clock;
  Series<AngleSample> series;
  std::uint64_t not_finite{0};
  std::uint64_t beyond_limit{0};
  double lowest{std::numeric_limits<double>::infinity()};  ///< [rad] after scale and offset
  double highest{-std::numeric_limits<double>::infinity()};
};

/// What one pass over a bag keeps of it: statistics, and series at 20 Hz at most, whatever its length. Times
/// `t` are seconds since `origin`.
struct DriveRecord {
  explicit DriveRecord(const Parameters& drive_parameters);

  double secondsOf(Time stamp) const { return toSeconds(stamp - origin); }

  Parameters parameters;
  OdometryConfiguration configuration;
  PerWheel<bool> wheel_used;
  PerAxle<bool> steering_needed;

  Time origin;  ///< record time of the first message
  StampStatistics wheel_clock;
  std::vector<CounterWatch> counters;  ///< of each wheel
  Series<WheelSample> wheels;
  std::vector<SteeringWatch> steering;  ///< of each axle
  StampStatistics laser_clock;
  LaserWatch laser_watch;
  Series<LaserSample> laser;
  bool mount_known{false};
};

}  // namespace bs_car_odometry::tools::doctor
