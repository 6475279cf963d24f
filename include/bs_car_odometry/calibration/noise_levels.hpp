#pragma once

#include "bs_car_odometry/calibration/refinement.hpp"

namespace bs_car_odometry::calibration {

/// A standard deviation of the readings, found in drives.
struct NoiseLevel {
  double configured{0.0};
  double value{0.0};      ///< as configured where it was not found
  double deviation{0.0};  ///< standard deviation of the value; zero where it was not found
  bool found{false};      ///< false where the drives say too little of it

  double scale() const { return configured > 0.0 ? value / configured : 1.0; }
};

/// The noise that a calibration can find (docs/calibration.md, C25 to C28). Steering noise and side slip stay
/// as configured: a drive does not tell them from the noise of the wheels.
struct NoiseLevels {
  NoiseLevel wheel;           ///< noise/wheel [m/sqrt(m)]
  NoiseLevel laser_position;  ///< [m], root mean square over the poses and both axes
  NoiseLevel laser_yaw;       ///< [rad]
  double outliers{0.0};       ///< share of the laser poses that were left out
  bool converged{false};

  /// For RefinementOptions.
  LaserScales laserScales() const { return {laser_position.scale(), laser_yaw.scale()}; }
};

/// Maximum likelihood of the innovations; laser poses that do not fit are left out.
/// @param parameters  as for refine(); their noise levels are where the search begins
NoiseLevels estimateNoise(const Drives& drives, const Parameters& parameters,
                          const RefinementOptions& options = {});

/// The same configuration with the wheels' noise that was found.
Parameters withNoise(const NoiseLevels& levels, Parameters parameters);

}  // namespace bs_car_odometry::calibration
