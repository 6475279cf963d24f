#include "bs_car_odometry/core/steady_wheels.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

namespace {

// What a sound wheel cannot miss: half of what is a fault of its travel, ten times the speed below which
// drivers read zero, and its own rounding with twice that of those it is compared with.
constexpr double kShare = 0.01;
constexpr double kSpeed = 0.1;  // [m/s]
constexpr double kRoundings = 3.0;
constexpr double kExact = 1e-6;  // of a tick

/// A counter rounds at both ends of a stretch, so that each of the two is known to less than a tick.
double rounding(double tick, const SteadyWheels::Run& run, double seconds) {
  return tick * (1.0 + seconds / run.seconds);
}

/// [m] by which a stretch's travel departs from that at the speed of the run's first.
double departure(const SteadyWheels::Run& run, Wheel wheel, const StepReadings& stretch, double seconds) {
  return std::abs(stretch.travel[wheel] - run.first.travel[wheel] * seconds / run.seconds);
}

}  // namespace

SteadyWheels::SteadyWheels(const Vehicle& vehicle) { setVehicle(vehicle); }

void SteadyWheels::setVehicle(const Vehicle& vehicle) {
  for (const Wheel wheel : kAllWheels) {
    const double tick = std::abs(vehicle.calibratedMetresPerTick(wheel));
    if (tick_[wheel] > 0.0)
      for (Run& run : runs_.values) run.first.travel[wheel] *= tick / tick_[wheel];
    tick_[wheel] = tick;
  }
  for (Run& run : runs_.values) run.all = PendingReadings();
}

void SteadyWheels::add(const StepReadings& stretch, double seconds) {
  for (const Wheel wheel : kAllWheels) {
    Run& run = runs_[wheel];
    if (run.stretches == 0 || departs(run, wheel, stretch, seconds)) run = {stretch, seconds, 0, {}};
    ++run.stretches;
    run.all.add(stretch);
  }
}

bool SteadyWheels::departs(const Run& run, Wheel wheel, const StepReadings& stretch, double seconds) const {
  return departure(run, wheel, stretch, seconds) >
         rounding(tick_[wheel], run, seconds) - kExact * tick_[wheel];
}

double SteadyWheels::leastChange(Wheel wheel, const StepReadings& stretch, double seconds) const {
  const double coarsest = *std::max_element(tick_.values.begin(), tick_.values.end());
  return std::max({kSpeed, kShare * std::abs(stretch.travel[wheel]) / seconds,
                   kRoundings * rounding(coarsest, runs_[wheel], seconds) / seconds});
}

bool SteadyWheels::isLeftBehind(Wheel wheel, const StepReadings& stretch, double seconds,
                                const PerWheel<bool>& ignored) const {
  const double change = leastChange(wheel, stretch, seconds);
  for (const Wheel other : kAllWheels) {
    if (other == wheel || ignored[other] || tick_[other] == 0.0) continue;
    if (departure(runs_[wheel], other, stretch, seconds) < change * seconds) return false;
  }
  return true;
}

}  // namespace bs_car_odometry
