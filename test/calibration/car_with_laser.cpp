#include "car_with_laser.hpp"

#include "bs_car_odometry/calibration/odometry_for_calibration.hpp"
#include "bs_car_odometry/parameters/configuration.hpp"

#include <cmath>
#include <utility>

namespace bs_car_odometry::calibration {

namespace {

constexpr Time kStart = timeFromNanoseconds(1600000000000000000);

simulation::SimulationOptions optionsOf(const CarSettings& settings) {
  simulation::SimulationOptions options;
  options.seed = settings.seed;
  options.substep = 0.01;
  return options;
}

Pose2 poseOf(const simulation::Pose& pose) { return {pose.x, pose.y, pose.yaw}; }

}  // namespace

Parameters cycabWithLaser() {
  Parameters p;
  p.vehicle.name = "cycab";
  p.vehicle.wheelbase = 1.2;
  p.vehicle.track = {1.2, 1.2};
  p.vehicle.metres_per_tick.values.fill(1e-4);
  return p;
}

simulation::Scenario scenarioNamed(const std::string& name) {
  return simulation::makeScenario(name, cycabWithLaser().vehicle);
}

simulation::Scenario scenarioOf(double period, const std::function<simulation::Command(double)>& pattern) {
  return {"own", period, period, pattern, {}};
}

CarWithLaser::CarWithLaser(const CarSettings& settings)
    : settings_(settings),
      truth_(simulation::withScenarioGains(settings.parameters.vehicle)),
      car_(settings.parameters.vehicle, truth_,
           settings.noise ? std::optional<NoiseModel>(settings.parameters.noise) : std::nullopt,
           settings.scenario, optionsOf(settings)),
      pipeline_(toConfiguration(odometryForCalibration(settings.parameters))) {}

void CarWithLaser::driveUntil(double time, Calibrator& calibrator) {
  for (; next_step_ / settings_.rate <= time; ++next_step_) {
    car_.advanceTo(next_step_ / settings_.rate);
    const Time stamp = kStart + durationFromSeconds(car_.time());
    pipeline_.addSteering(Axle::kFront, stamp, stamp, car_.readSteering(Axle::kFront));
    pipeline_.addWheels({stamp, stamp, car_.readCounters()});
    while (const std::optional<OdometryUpdate> update = pipeline_.next(stamp)) {
      calibrator.add(*update);
      if (listener_) listener_(*update);
    }
    if (next_step_ % settings_.steps_per_pose == 0) readLaser();
    deliver(calibrator);
  }
}

void CarWithLaser::readLaser() {
  const LaserMount& mount = settings_.parameters.laser;
  const LaserSigma& sigma = settings_.parameters.laser_sigma;
  const double noise = settings_.noise ? 1.0 : 0.0;
  LaserPose laser;
  laser.stamp = kStart + durationFromSeconds(car_.time() + settings_.laser_lag);
  laser.pose =
      poseOf(car_.readLaser({mount.x, mount.y, mount.yaw}, noise * sigma.position, noise * sigma.yaw));
  laser.covariance = Eigen::Vector3d(sigma.position, sigma.position, sigma.yaw).cwiseAbs2().asDiagonal();
  if (settings_.disturb) settings_.disturb(car_.time(), laser.pose);
  on_the_way_.emplace_back(car_.time() + settings_.laser_lag + settings_.laser_latency, laser);
}

void CarWithLaser::deliver(Calibrator& calibrator) {
  for (; !on_the_way_.empty() && on_the_way_.front().first <= car_.time(); on_the_way_.pop_front())
    calibrator.add(on_the_way_.front().second);
}

Pose2 CarWithLaser::truePose() const { return poseOf(car_.truePose()); }

ParameterVector CarWithLaser::trueValues() const {
  Parameters p = settings_.parameters;
  p.vehicle.gains = truth_.gains;
  p.vehicle.steering = truth_.steering;
  p.laser.time_offset = settings_.laser_lag;
  return valuesOf(p);
}

}  // namespace bs_car_odometry::calibration
