#pragma once

#include "bs_car_odometry/calibration/filter.hpp"
#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/laboratory/drive.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace bs_car_odometry::laboratory {

/// What the gains of a simulated car truly are, those of both axles, over what is configured.
struct TrueGains {
  enum class Kind {
    kConfigured,  ///< as configured
    kScenario,    ///< (k_r, k_l, k_b) = (1.02, 0.99, 1.03) times that
    kDrawn,       ///< Gaussian errors of standard deviation `size`
    kWrong,       ///< each off by `size`, its sign drawn
  };
  Kind kind{Kind::kDrawn};
  double size{0.02};
};

/// The car as it truly is.
Vehicle trueVehicle(const Vehicle& configured, const TrueGains& gains, std::uint64_t seed);

/// Errors of a laser's poses.
struct LaserErrors {
  bool noise{true};        ///< as Parameters::laser_sigma says
  double outliers{0.0};    ///< their share; they are off by more,
  double position{1.0};    ///< uniform within +/- this in x and in y [m]
  double yaw{0.3};         ///< and in yaw [rad]
  double delay{0.0};       ///< [s] by which every stamp is late,
  double delay_draw{0.0};  ///< and further by up to this, drawn for the drive [s]
};

/// A drive of a car whose true parameters are known.
struct KnownDrive {
  Parameters truth;
  std::vector<Sample> samples;
};

/// How often the laser measures: at every fifth sample, from the first one on.
constexpr std::size_t kLaserEvery = 5;

/// Poses of a laser in base_link, with the covariance of their noise; of outliers it says nothing.
/// @param delay  [s] of these stamps
std::vector<calibration::LaserPose> laserPoses(const KnownDrive& drive, const LaserErrors& errors,
                                               double delay, std::uint64_t seed);

/// The delay of a drive [s].
double delayOf(const LaserErrors& errors, std::uint64_t seed);

/// What the odometry makes of a drive by configured values.
std::vector<OdometryUpdate> odometryOf(const Parameters& configured, const std::vector<Sample>& samples);

}  // namespace bs_car_odometry::laboratory
