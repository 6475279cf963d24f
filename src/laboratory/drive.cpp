#include "bs_car_odometry/laboratory/drive.hpp"

#include "bs_car_odometry/simulation/scenario.hpp"

#include <cmath>
#include <stdexcept>

namespace bs_car_odometry::laboratory {

namespace {

constexpr Time kStart = timeFromNanoseconds(1600000000000000000);

Sample read(simulation::SimulatedCar& car) {
  Sample sample;
  sample.time = car.time();
  sample.ticks = car.readCounters();
  for (const Axle axle : kAllAxles) sample.steering[axle] = car.readSteering(axle);
  sample.truth = car.truePose();
  return sample;
}

}  // namespace

std::vector<Sample> record(const Vehicle& vehicle, const DriveSettings& settings) {
  simulation::SimulationOptions options;
  options.seed = settings.seed;
  options.substep = settings.substep;
  options.drivetrain = simulation::drivetrainOf(vehicle, settings.axles);
  const simulation::Scenario scenario =
      simulation::makeScenario(settings.scenario, vehicle, options.drivetrain, settings.speed_factor);
  const simulation::TrueParameters truth =
      settings.draw_gains ? simulation::drawnFrom(*settings.draw_gains, vehicle, settings.seed)
                          : simulation::asConfigured(vehicle);
  simulation::SimulatedCar car(vehicle, truth, settings.noise, scenario, options);
  const double duration = settings.duration > 0.0 ? settings.duration : scenario.duration;
  const auto steps = static_cast<std::size_t>(std::lround(duration * settings.rate));
  std::vector<Sample> drive;
  drive.reserve(steps + 1);
  for (std::size_t i = 0; i <= steps; ++i) {
    car.advanceTo(static_cast<double>(i) / settings.rate);
    drive.push_back(read(car));
  }
  return drive;
}

Time stampOf(const Sample& sample) { return kStart + durationFromSeconds(sample.time); }

OdometryUpdate step(OdometryPipeline& pipeline, const Sample& sample) {
  const Time stamp = stampOf(sample);
  for (const Axle axle : kAllAxles)
    if (pipeline.steeringNeeded()[axle]) pipeline.addSteering(axle, stamp, stamp, sample.steering[axle]);
  pipeline.addWheels({stamp, stamp, sample.ticks});
  const std::optional<OdometryUpdate> update = pipeline.next(stamp);
  if (!update) throw std::logic_error("a sample gave no odometry");
  return *update;
}

void replay(const OdometryConfiguration& configuration, const std::vector<Sample>& drive,
            const Visitor& visit) {
  OdometryPipeline pipeline(configuration);
  for (const Sample& sample : drive) visit(sample, step(pipeline, sample));
}

}  // namespace bs_car_odometry::laboratory
