#include "bs_car_odometry/simulation/simulated_car.hpp"

#include <cmath>

namespace bs_car_odometry::simulation {

namespace {

// Streams of the random numbers; TrueMotion has 0 and 1.
constexpr std::uint64_t kWheelStream = 10;
constexpr std::uint64_t kSteeringStream = 20;
constexpr std::uint64_t kLaserStream = 30;

NoiseModel noNoise() {
  NoiseModel noise;
  noise.wheel = 0.0;
  noise.steering.angle = 0.0;
  noise.lateral = 0.0;
  noise.rear_law = 0.0;
  return noise;
}

TrueMotion::Noise motionNoise(const Vehicle& vehicle, const NoiseModel& noise) {
  const bool slaved = vehicle.rear_steering.source == RearSteering::Source::kPolynomial;
  return {noise.lateral, slaved ? noise.rear_law : 0.0, noise.steering.correlation_length};
}

WheelEncoder makeEncoder(Wheel wheel, const Vehicle& vehicle, const TrueParameters& truth,
                         const NoiseModel& noise, const SimulationOptions& options) {
  const AxleGains& gains = truth.gains[axleOf(wheel)];
  WheelEncoder::Settings settings;
  settings.metres_per_tick = (isLeft(wheel) ? gains.k_l : gains.k_r) * vehicle.metres_per_tick[wheel];
  settings.noise = noise.wheel;
  settings.counter_bits = vehicle.counter_bits;
  settings.start = options.counter_start[wheel];
  return {settings, Random(options.seed, kWheelStream + index(wheel))};
}

std::array<WheelEncoder, kWheels> makeEncoders(const Vehicle& vehicle, const TrueParameters& truth,
                                               const NoiseModel& noise, const SimulationOptions& options) {
  const auto encoder = [&](Wheel wheel) { return makeEncoder(wheel, vehicle, truth, noise, options); };
  return {encoder(Wheel::kFrontLeft), encoder(Wheel::kFrontRight), encoder(Wheel::kRearLeft),
          encoder(Wheel::kRearRight)};
}

CorrelatedError steeringError(Axle axle, const NoiseModel& noise, std::uint64_t seed) {
  return {noise.steering.angle, noise.steering.correlation_length,
          Random(seed, kSteeringStream + index(axle))};
}

}  // namespace

SimulatedCar::SimulatedCar(const Vehicle& vehicle, const TrueParameters& truth,
                           const std::optional<NoiseModel>& noise, const Scenario& scenario,
                           const SimulationOptions& options)
    : motion_(TrueBody(vehicle, truth, options.drivetrain), scenario,
              motionNoise(vehicle, noise.value_or(noNoise())), options.seed, options.substep,
              options.initial_pose),
      encoders_(makeEncoders(vehicle, truth, noise.value_or(noNoise()), options)),
      front_sensor_{truth.steering.front,
                    steeringError(Axle::kFront, noise.value_or(noNoise()), options.seed)},
      rear_sensor_{truth.steering.rear, steeringError(Axle::kRear, noise.value_or(noNoise()), options.seed)},
      laser_random_(options.seed, kLaserStream) {}

PerWheel<std::int64_t> SimulatedCar::readCounters() {
  PerWheel<std::int64_t> counters;
  for (Wheel wheel : kAllWheels) counters[wheel] = encoders_[index(wheel)].read(motion_.travel(wheel));
  return counters;
}

double SimulatedCar::readSteering(Axle axle) {
  SteeringSensor& sensor = this->sensor(axle);
  const double left = motion_.kingpinTravel(leftWheel(axle));
  const double right = motion_.kingpinTravel(rightWheel(axle));
  const double axle_travel =
      0.5 * (std::abs(left - sensor.left_travel) + std::abs(right - sensor.right_travel));
  sensor.left_travel = left;
  sensor.right_travel = right;
  const double measured = motion_.angle(axle) + sensor.error.advance(axle_travel);
  return (measured - sensor.calibration.offset) / sensor.calibration.scale;
}

Pose SimulatedCar::readLaser(const Pose& mount, double sigma_position, double sigma_yaw) {
  const Pose& base = motion_.pose();
  const double c = std::cos(base.yaw);
  const double s = std::sin(base.yaw);
  const double error_x = sigma_position * laser_random_.normal();
  const double error_y = sigma_position * laser_random_.normal();
  return {base.x + c * mount.x - s * mount.y + error_x, base.y + s * mount.x + c * mount.y + error_y,
          base.yaw + mount.yaw + sigma_yaw * laser_random_.normal()};
}

}  // namespace bs_car_odometry::simulation
