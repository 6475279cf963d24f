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

Time stampOf(const Sample& sample) { return kStart + durationFromSeconds(sample.time); }

void addSteering(OdometryPipeline& pipeline, const Sample& sample, Time stamp) {
  for (const Axle axle : kAllAxles)
    if (pipeline.steeringNeeded()[axle]) pipeline.addSteering(axle, stamp, stamp, sample.steering[axle]);
}

OdometryUpdate step(OdometryPipeline& pipeline, const Sample& sample) {
  const Time stamp = stampOf(sample);
  addSteering(pipeline, sample, stamp);
  pipeline.addWheels({stamp, stamp, sample.ticks});
  const std::optional<OdometryUpdate> update = pipeline.next(stamp);
  if (!update) throw std::logic_error("a sample gave no odometry");
  return *update;
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
  const simulation::TrueParameters truth =
      settings.draw_parameters
          ? simulation::drawnFrom(settings.noise.value().systematic, vehicle, settings.seed)
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

void replay(const OdometryConfiguration& configuration, const std::vector<Sample>& drive,
            const Visitor& visit) {
  OdometryPipeline pipeline(configuration);
  for (const Sample& sample : drive) visit(sample, step(pipeline, sample).estimate);
}

MotionEstimate motionBetween(const OdometryConfiguration& configuration, const std::vector<Sample>& drive,
                             std::size_t from, std::size_t to, std::size_t every) {
  OdometryPipeline pipeline(configuration);
  for (std::size_t i = 0; i < drive.size(); i += every) step(pipeline, drive[i]);
  const auto motion = pipeline.motionHistory().between(stampOf(drive.at(from)), stampOf(drive.at(to)));
  if (!motion) throw std::logic_error("the motion between two samples is not known");
  return *motion;
}

simulation::Pose trueMotion(const std::vector<Sample>& drive, std::size_t from, std::size_t to) {
  const simulation::Pose& a = drive.at(from).truth;
  const simulation::Pose& b = drive.at(to).truth;
  const double c = std::cos(a.yaw);
  const double s = std::sin(a.yaw);
  return {c * (b.x - a.x) + s * (b.y - a.y), c * (b.y - a.y) - s * (b.x - a.x), b.yaw - a.yaw};
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
