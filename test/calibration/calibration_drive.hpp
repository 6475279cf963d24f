#pragma once

#include "bs_car_odometry/calibration/calibrator.hpp"
#include "bs_car_odometry/calibration/odometry_for_calibration.hpp"
#include "bs_car_odometry/laboratory/calibration_drive.hpp"
#include "bs_car_odometry/parameters/configuration.hpp"

#include <cstdint>
#include <functional>
#include <vector>

/// Simulated drives with a laser, for tests of the calibration.
namespace bs_car_odometry::calibration {

/// The round car of the scenarios; tick marks fine enough not to matter.
inline Parameters testParameters() {
  Parameters parameters;
  Vehicle& vehicle = parameters.vehicle;
  vehicle.name = "test";
  vehicle.wheelbase = 1.2;
  vehicle.track = {1.2, 1.2};
  vehicle.metres_per_tick = {{1e-4, 1e-4, 1e-4, 1e-4}};
  return parameters;
}

/// What the laser of a car sees of a drive, each fifth sample.
/// @param car  its laser mount, delay and noise are those of the true car
inline std::vector<LaserPose> laserPoses(const std::vector<laboratory::Sample>& drive, const Parameters& car,
                                         std::uint64_t seed, const laboratory::LaserErrors& errors = {}) {
  return laboratory::laserPoses({car, drive}, errors, car.laser.time_offset, seed);
}

/// Gives a calibrator a drive, each laser pose `delay` samples after the sample it was taken at.
/// @param listener  hears of each update of the odometry first
inline void calibrate(Calibrator& calibrator, const Parameters& parameters,
                      const std::vector<laboratory::Sample>& drive, const std::vector<LaserPose>& lasers,
                      std::size_t delay = 0,
                      const std::function<void(const OdometryUpdate&)>& listener = {}) {
  constexpr std::size_t kEvery = laboratory::kLaserEvery;
  OdometryPipeline pipeline(toConfiguration(odometryForCalibration(parameters)));
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const Time stamp = laboratory::stampOf(drive[i]);
    for (const Axle axle : kAllAxles)
      if (pipeline.steeringNeeded()[axle]) pipeline.addSteering(axle, stamp, stamp, drive[i].steering[axle]);
    pipeline.addWheels({stamp, stamp, drive[i].ticks});
    while (const auto update = pipeline.next(stamp)) {
      if (listener) listener(*update);
      calibrator.add(*update);
    }
    if (i >= delay && (i - delay) % kEvery == 0) calibrator.add(lasers[(i - delay) / kEvery]);
  }
}

}  // namespace bs_car_odometry::calibration
