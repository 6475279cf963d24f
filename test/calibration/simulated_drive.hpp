#pragma once

#include "bs_car_odometry/calibration/filter.hpp"
#include "bs_car_odometry/calibration/odometry_for_calibration.hpp"
#include "bs_car_odometry/laboratory/drive.hpp"
#include "bs_car_odometry/parameters/configuration.hpp"
#include "bs_car_odometry/simulation/simulated_car.hpp"

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace bs_car_odometry::calibration {

/// A Cycab with the default noise, 0.1 mm a tick, calibrated by its rear axle.
inline Parameters cycab(double prior = 0.02) {
  Parameters p;
  p.vehicle.wheelbase = 1.2;
  p.vehicle.track = {1.2, 1.2};
  for (const Wheel wheel : kAllWheels) p.vehicle.metres_per_tick[wheel] = 1e-4;
  p.odometry.axles = AxleSelection::kRear;
  p.calibration.method = CalibrationMethod::kPaper;
  p.calibration.prior.k_r = p.calibration.prior.k_l = p.calibration.prior.k_b = prior;
  return p;
}

/// One laser pose and the steps that lead there.
struct Leg {
  std::vector<MeasuredStep> steps;
  LaserPose laser;
  double distance{0.0};  ///< [m] truly driven by the middle of the rear axle since the beginning
};

inline Pose2 poseOf(const simulation::Pose& pose) { return {pose.x, pose.y, pose.yaw}; }

/// Drives a scenario at 50 Hz with a laser at 10 Hz; the first leg has no steps.
/// @param noise  of wheels, angles and laser: the configured one, or none
inline std::vector<Leg> drive(const Parameters& p, const simulation::TrueParameters& truth,
                              const std::string& scenario, std::uint64_t seed, bool noise = true) {
  simulation::SimulationOptions options;
  options.seed = seed;
  options.substep = 0.01;
  const simulation::Scenario path = simulation::makeScenario(scenario, p.vehicle);
  simulation::SimulatedCar car(p.vehicle, truth, noise ? std::optional<NoiseModel>(p.noise) : std::nullopt,
                               path, options);
  OdometryPipeline pipeline(toConfiguration(odometryForCalibration(p)));
  const double position = noise ? p.laser_sigma.position : 0.0;
  const double yaw = noise ? p.laser_sigma.yaw : 0.0;
  const Eigen::Vector3d sigma(p.laser_sigma.position, p.laser_sigma.position, p.laser_sigma.yaw);
  const Eigen::Matrix3d covariance = sigma.cwiseAbs2().asDiagonal();
  std::vector<Leg> legs;
  Leg leg;
  for (int i = 0; i <= static_cast<int>(std::lround(50.0 * path.duration)); ++i) {
    laboratory::Sample sample;
    car.advanceTo(0.02 * i);
    sample.time = car.time();
    sample.ticks = car.readCounters();
    for (const Axle axle : kAllAxles) sample.steering[axle] = car.readSteering(axle);
    const OdometryUpdate update = laboratory::step(pipeline, sample);
    if (update.step) leg.steps.push_back(*update.step);
    if (i % 5 != 0) continue;
    leg.laser = {update.stamp, poseOf(car.readLaser({p.laser.x, p.laser.y, p.laser.yaw}, position, yaw)),
                 covariance};
    leg.distance = 0.5 * (car.trueTravel(Wheel::kRearLeft) + car.trueTravel(Wheel::kRearRight));
    legs.push_back(leg);
    leg.steps.clear();
  }
  return legs;
}

/// Begins at the first laser pose, or goes on from the drive before when `begin` is false.
inline void follow(const std::vector<Leg>& drive, Filter& filter) {
  filter.begin(drive.front().laser);
  for (std::size_t i = 1; i < drive.size(); ++i) {
    for (const MeasuredStep& step : drive[i].steps) filter.move(step);
    filter.update(drive[i].laser, 0.0);
  }
}

}  // namespace bs_car_odometry::calibration
