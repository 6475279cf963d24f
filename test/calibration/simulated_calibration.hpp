#pragma once

#include "bs_car_odometry/calibration/calibration_drive.hpp"
#include "bs_car_odometry/laboratory/drive.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace bs_car_odometry::calibration {

/// Laser poses that are nowhere near the car: uniform in +/- so much about the truth.
struct LaserOutliers {
  double share{0.0};
  double position{1.0};  ///< [m]
  double yaw{0.3};       ///< [rad]
};

/// A drive with a laser, as it truly is.
struct SimulatedDrive {
  std::string scenario{"fig4"};
  double duration{0.0};  ///< [s], 0: the scenario's
  double rate{50.0};     ///< [Hz] of wheels and steering; the laser has a fifth of it
  std::uint64_t seed{1};
  std::optional<NoiseModel> noise;  ///< of wheels and steering; none: exact but for rounding
  LaserSigma laser_sigma;           ///< a standard deviation of zero: exact
  LaserOutliers outliers;
  double jump_after{0.0};  ///< [s] when the localiser's map moves by metres; 0: never
  ParameterVector truth;   ///< gains, steering, laser mount and delay of the true car
};

/// What a calibration makes of it.
struct CalibratedDrive {
  CalibrationDrive drive;
  FilterEstimate filter;
};

/// A Cycab of which the calibration knows the nominal values, 0.02 m and 0.005 rad of laser noise.
Parameters cycabParameters(AxleSelection axles = AxleSelection::kRear);

/// Parameters drawn from their prior.
ParameterVector drawTruth(const Parameters& parameters, std::uint64_t seed);

/// Drives, and takes every laser pose to a Calibrator of the configured parameters. The laser poses come with
/// the configured `laser_sigma`, whatever their true noise.
CalibratedDrive calibrate(const SimulatedDrive& simulated, const Parameters& parameters);

constexpr std::array<std::size_t, 3> kRearGains{systematic::kRearRight, systematic::kRearLeft,
                                                systematic::kRearTrack};

/// The Cycab, with this prior for each gain.
Parameters withPrior(double prior, AxleSelection axles = AxleSelection::kRear);

/// A drive with noise as configured and parameters drawn from their prior.
SimulatedDrive drawnDrive(const std::string& scenario, const Parameters& parameters, std::uint64_t seed);

/// A prior that pulls at nothing, and ticks of 0.1 um.
Parameters exactParameters();
/// A drive of theirs without noise, with gains of 1.02, 0.99, 1.03; steps so short that their mean angle is
/// exact.
SimulatedDrive exactDrive(const Parameters& parameters);

double deviation(const ParameterMatrix& covariance, std::size_t parameter);

/// Smallest bound of the deviations: that of a drive without noise at the configured values.
ParameterVector boundOf(const std::string& scenario, const Parameters& parameters);

}  // namespace bs_car_odometry::calibration
