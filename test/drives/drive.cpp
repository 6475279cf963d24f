#include "drive.hpp"

#include "bs_car_odometry/simulation/scenario.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace bs_car_odometry::drives {

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

void addSteering(OdometryPipeline& pipeline, const Sample& sample, Time stamp) {
  for (const Axle axle : kAllAxles)
    if (pipeline.steeringNeeded()[axle]) pipeline.addSteering(axle, stamp, stamp, sample.steering[axle]);
}

double distance(const OdometryEstimate& estimate, const simulation::Pose& truth) {
  return std::hypot(estimate.pose.x - truth.x, estimate.pose.y - truth.y);
}

}  // namespace

std::vector<Sample> record(const Vehicle& vehicle, const DriveSettings& settings) {
  simulation::SimulationOptions options;
  options.seed = settings.seed;
  options.substep = settings.substep;
  options.drivetrain = simulation::drivetrainOf(vehicle, settings.axles);
  const simulation::Scenario scenario =
      simulation::makeScenario(settings.scenario, vehicle, options.drivetrain, settings.speed_factor);
  simulation::SimulatedCar car(vehicle, simulation::asConfigured(vehicle), settings.noise, scenario, options);
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

void replay(const OdometryConfiguration& configuration, const std::vector<Sample>& drive,
            const Visitor& visit) {
  OdometryPipeline pipeline(configuration);
  for (const Sample& sample : drive) {
    const Time stamp = kStart + durationFromSeconds(sample.time);
    addSteering(pipeline, sample, stamp);
    pipeline.addWheels({stamp, stamp, sample.ticks});
    const std::optional<OdometryUpdate> update = pipeline.next(stamp);
    if (!update) throw std::logic_error("a sample gave no odometry");
    visit(sample, update->estimate);
  }
}

OdometryEstimate endOf(const OdometryConfiguration& configuration, const std::vector<Sample>& drive) {
  OdometryEstimate end;
  replay(configuration, drive, [&end](const Sample&, const OdometryEstimate& estimate) { end = estimate; });
  return end;
}

Departure departure(const OdometryConfiguration& configuration, const std::vector<Sample>& drive) {
  Departure departure;
  replay(configuration, drive, [&](const Sample& sample, const OdometryEstimate& estimate) {
    departure.at_end = distance(estimate, sample.truth);
    departure.largest = std::max(departure.largest, departure.at_end);
  });
  return departure;
}

OdometryConfiguration odometryOf(const Vehicle& vehicle, AxleSelection axles) {
  OdometryConfiguration configuration;
  configuration.vehicle = vehicle;
  configuration.options.axles = axles;
  return configuration;
}

const char* name(AxleSelection axles) {
  switch (axles) {
    case AxleSelection::kBoth:
      return "both";
    case AxleSelection::kFront:
      return "front";
    case AxleSelection::kRear:
      return "rear";
  }
  return "";
}

const char* name(AxleGeometry geometry) {
  return geometry == AxleGeometry::kAckermann ? "ackermann" : "pivot";
}

}  // namespace bs_car_odometry::drives
