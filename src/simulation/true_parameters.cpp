#include "bs_car_odometry/simulation/true_parameters.hpp"

#include "bs_car_odometry/simulation/random.hpp"

namespace bs_car_odometry::simulation {

namespace {

constexpr std::uint64_t kSystematicStream = 100;  // apart from those of SimulatedCar

}  // namespace

TrueParameters asConfigured(const Vehicle& vehicle) { return {vehicle.gains, vehicle.steering}; }

TrueParameters withScenarioGains(const Vehicle& vehicle) {
  TrueParameters truth = asConfigured(vehicle);
  for (Axle axle : kAllAxles) {
    truth.gains[axle].k_r *= 1.02;
    truth.gains[axle].k_l *= 0.99;
    truth.gains[axle].k_b *= 1.03;
  }
  return truth;
}

TrueParameters drawnFrom(const SystematicNoise& systematic, const Vehicle& vehicle, std::uint64_t seed) {
  TrueParameters truth = asConfigured(vehicle);
  Random random(seed, kSystematicStream);
  const bool rear_measured = vehicle.rear_steering.source == RearSteering::Source::kMeasured;
  for (Axle axle : kAllAxles) {
    truth.gains[axle].k_r += random.draw(systematic.k_r);
    truth.gains[axle].k_l += random.draw(systematic.k_l);
    truth.gains[axle].k_b += random.draw(systematic.k_b);
    const double offset_error = random.draw(systematic.steering_offset);
    if (axle == Axle::kFront || rear_measured) truth.steering[axle].offset += offset_error;
  }
  return truth;
}

}  // namespace bs_car_odometry::simulation
