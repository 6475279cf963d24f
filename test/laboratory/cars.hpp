#pragma once

#include "bs_car_odometry/laboratory/consistency.hpp"

namespace bs_car_odometry::laboratory {

/// A Cycab's odometry with the default noise, 0.1 mm a tick.
inline OdometryConfiguration cycabOdometry(AxleSelection axles = AxleSelection::kBoth,
                                           AxleGeometry geometry = AxleGeometry::kAckermann) {
  OdometryConfiguration configuration;
  configuration.vehicle.wheelbase = 1.2;
  configuration.vehicle.track = {1.2, 1.2};
  configuration.vehicle.axle_geometry = geometry;
  for (const Wheel wheel : kAllWheels) configuration.vehicle.metres_per_tick[wheel] = 1e-4;
  configuration.options.axles = axles;
  return configuration;
}

/// Noisy drives with parameters from p(A), 50 Hz. At 20 Hz the sampling of the steering alone would show.
inline StudySettings studyOf(const std::vector<OdometryConfiguration>& odometries, const char* scenario) {
  StudySettings study;
  study.drive.scenario = scenario;
  study.drive.rate = 50.0;
  study.drive.substep = 0.01;
  study.drive.noise = odometries.front().noise;
  study.drive.draw_gains = odometries.front().noise.systematic;
  study.odometries = odometries;
  return study;
}

}  // namespace bs_car_odometry::laboratory
