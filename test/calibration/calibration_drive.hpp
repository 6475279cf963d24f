#pragma once

#include "bs_car_odometry/calibration/calibrator.hpp"
#include "bs_car_odometry/laboratory/drive.hpp"
#include "bs_car_odometry/parameters/configuration.hpp"
#include "bs_car_odometry/simulation/random.hpp"

#include <cmath>
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

struct LaserSettings {
  std::uint64_t seed{1};
  int every{5};  ///< samples
  LaserMount mount;
  double noise{1.0};  ///< times laser_sigma
  std::function<void(simulation::Random&, std::size_t, Pose2&)> disturb;
};

/// What the laser sees of a drive.
inline std::vector<LaserPose> laserPoses(const std::vector<laboratory::Sample>& drive,
                                         const Parameters& parameters, const LaserSettings& settings) {
  simulation::Random random(settings.seed, 1000);
  const double position = settings.noise * parameters.laser_sigma.position;
  const double yaw = settings.noise * parameters.laser_sigma.yaw;
  std::vector<LaserPose> lasers;
  for (std::size_t i = 0; i < drive.size(); i += static_cast<std::size_t>(settings.every)) {
    const simulation::Pose& truth = drive[i].truth;
    const LaserMount& mount = settings.mount;
    Pose2 pose = Pose2{truth.x, truth.y, truth.yaw} * Pose2{mount.x, mount.y, mount.yaw};
    pose.x += position * random.normal();
    pose.y += position * random.normal();
    pose.yaw += yaw * random.normal();
    if (settings.disturb) settings.disturb(random, lasers.size(), pose);
    const Eigen::Vector3d sigmas(parameters.laser_sigma.position, parameters.laser_sigma.position,
                                 parameters.laser_sigma.yaw);
    lasers.push_back({laboratory::stampOf(drive[i]) + durationFromSeconds(mount.time_offset), pose,
                      sigmas.cwiseAbs2().asDiagonal()});
  }
  return lasers;
}

/// Gives a calibrator a drive, each laser pose `delay` samples after the sample it was taken at.
inline void calibrate(Calibrator& calibrator, const Parameters& parameters,
                      const std::vector<laboratory::Sample>& drive, const std::vector<LaserPose>& lasers,
                      std::size_t every = 5, std::size_t delay = 0) {
  OdometryPipeline pipeline(toConfiguration(parameters));
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const Time stamp = laboratory::stampOf(drive[i]);
    for (const Axle axle : kAllAxles)
      if (pipeline.steeringNeeded()[axle]) pipeline.addSteering(axle, stamp, stamp, drive[i].steering[axle]);
    pipeline.addWheels({stamp, stamp, drive[i].ticks});
    while (const auto update = pipeline.next(stamp)) calibrator.add(*update);
    if (i >= delay && (i - delay) % every == 0) calibrator.add(lasers[(i - delay) / every]);
  }
}

}  // namespace bs_car_odometry::calibration
