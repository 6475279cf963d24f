#include "bench.hpp"

#include "bs_car_odometry/simulation/simulated_car.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

namespace bs_car_odometry::bench {

namespace {

constexpr std::int64_t kStart = 1600000000000000000;  // ns
constexpr double kWheelDelay = 0.001;                 // s, stamp to receipt
constexpr double kSteeringDelay = 0.002;              // s

template <typename T>
bool sameBits(const T& a, const T& b) {
  return std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

std::array<double, 3> numbers(const Pose2& pose) { return {pose.x, pose.y, pose.yaw}; }

void feed(OdometryPipeline& pipeline, const Message& message) {
  if (message.isWheels()) {
    pipeline.addWheels({at(message.stamp), at(message.receipt), *message.ticks});
  } else {
    pipeline.addSteering(Axle::kFront, at(message.stamp), at(message.receipt), message.angle);
  }
}

void take(OdometryPipeline& pipeline, Time now, std::vector<OdometryUpdate>& updates) {
  while (const auto update = pipeline.next(now)) updates.push_back(*update);
}

}  // namespace

OdometryConfiguration cycab() {
  OdometryConfiguration configuration;
  configuration.vehicle.wheelbase = 1.2;
  configuration.vehicle.track = {1.2, 1.2};
  for (double& metres : configuration.vehicle.metres_per_tick.values) metres = 1e-4;
  configuration.limits.max_speed = 5.0;
  // Counters and angles of these tests are made up one by one, and contradict each other.
  configuration.options.fault_detection = false;
  configuration.initial_pose.x = 1.0;
  configuration.initial_pose.y = -2.0;
  configuration.initial_pose.yaw = 0.5;
  configuration.initial_pose.covariance = Eigen::Vector3d(1e-4, 2e-4, 3e-4).asDiagonal();
  return configuration;
}

Time at(double seconds) { return timeFromNanoseconds(kStart) + durationFromSeconds(seconds); }

PerWheel<std::int64_t> all(std::int64_t ticks) { return {{ticks, ticks, ticks, ticks}}; }

Verdict Bench::steer(double stamp, double angle, double receipt) {
  return pipeline.addSteering(Axle::kFront, at(stamp), at(receipt), angle);
}

Verdict Bench::wheels(double stamp, const PerWheel<std::int64_t>& ticks, double receipt) {
  return pipeline.addWheels({at(stamp), at(receipt), ticks});
}

std::optional<OdometryUpdate> Bench::step(double stamp, const PerWheel<std::int64_t>& ticks, double angle) {
  steer(stamp, angle);
  wheels(stamp, ticks);
  return next(stamp);
}

Drive slalom(const OdometryConfiguration& configuration, double duration, double wheel_rate,
             double steering_rate) {
  using namespace simulation;
  SimulationOptions options;
  const InitialPose& initial = configuration.initial_pose;
  options.initial_pose = {initial.x, initial.y, initial.yaw};
  SimulatedCar car(configuration.vehicle, asConfigured(configuration.vehicle), std::nullopt,
                   makeScenario("slalom_eight", configuration.vehicle), options);
  Drive drive;
  for (int wheel = 0, steering = 0;;) {
    const double wheel_time = wheel / wheel_rate;
    const double steering_time = steering / steering_rate;
    const double time = std::min(wheel_time, steering_time);
    if (time > duration) break;
    car.advanceTo(time);
    if (steering_time <= time) {
      const double angle = car.readSteering(Axle::kFront);
      drive.messages.push_back({time + kSteeringDelay, time, std::nullopt, angle});
      ++steering;
    }
    if (wheel_time <= time) {
      drive.messages.push_back({time + kWheelDelay, time, car.readCounters()});
      drive.truth.push_back({time, car.truePose()});
      ++wheel;
    }
  }
  std::stable_sort(drive.messages.begin(), drive.messages.end(),
                   [](const Message& a, const Message& b) { return a.receipt < b.receipt; });
  for (std::size_t i = 1; i < drive.truth.size(); ++i)
    drive.length += std::hypot(drive.truth[i].pose.x - drive.truth[i - 1].pose.x,
                               drive.truth[i].pose.y - drive.truth[i - 1].pose.y);
  return drive;
}

std::vector<OdometryUpdate> run(OdometryPipeline& pipeline, const std::vector<Message>& messages) {
  std::vector<OdometryUpdate> updates;
  for (const Message& message : messages) {
    take(pipeline, at(message.receipt), updates);
    feed(pipeline, message);
    take(pipeline, at(message.receipt), updates);
  }
  take(pipeline, timeFromNanoseconds(std::numeric_limits<std::int64_t>::max()), updates);
  return updates;
}

std::vector<OdometryUpdate> run(const OdometryConfiguration& configuration,
                                const std::vector<Message>& messages) {
  OdometryPipeline pipeline(configuration);
  return run(pipeline, messages);
}

bool identical(const OdometryEstimate& a, const OdometryEstimate& b) {
  return sameBits(numbers(a.pose), numbers(b.pose)) && sameBits(a.pose_covariance, b.pose_covariance) &&
         sameBits(a.twist, b.twist) && sameBits(a.twist_covariance, b.twist_covariance);
}

bool identical(const std::vector<OdometryUpdate>& a, const std::vector<OdometryUpdate>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const OdometryUpdate& one, const OdometryUpdate& other) {
                      return one.stamp == other.stamp && one.completed == other.completed &&
                             one.report.counts.verdicts == other.report.counts.verdicts &&
                             identical(one.estimate, other.estimate);
                    });
}

double largestDeparture(const std::vector<OdometryUpdate>& updates, const Drive& drive) {
  std::map<Time, simulation::Pose> truth;
  for (const Truth& sample : drive.truth) truth[at(sample.stamp)] = sample.pose;
  double largest = 0.0;
  for (const OdometryUpdate& update : updates) {
    const simulation::Pose& pose = truth.at(update.stamp);
    largest = std::max(largest, std::hypot(update.estimate.pose.x - pose.x, update.estimate.pose.y - pose.y));
  }
  return largest / drive.length;
}

bool isFinite(const OdometryUpdate& update) {
  const StepReport& report = update.report;
  double sum = report.interval + report.step + report.distance + report.residuals.chi_square;
  for (const double travel : report.wheel_travel.values) sum += travel;
  for (const double residual : report.residuals.wheel.values) sum += residual;
  for (const Axle axle : kAllAxles)
    sum += report.residuals.axle[axle] + report.steering_angle[axle] + report.steering_age[axle];
  const OdometryEstimate& estimate = update.estimate;
  return std::isfinite(sum) && estimate.pose.isFinite() && estimate.pose_covariance.allFinite() &&
         estimate.twist.allFinite() && estimate.twist_covariance.allFinite();
}

}  // namespace bs_car_odometry::bench
