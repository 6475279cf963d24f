#include "bs_car_odometry/core/steady_wheels.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

namespace {

// What a sound wheel cannot miss: half of what is a fault of its travel, ten times the speed below which
// drivers read zero, and what no rounding is.
constexpr double kShare = 0.01;
constexpr double kSpeed = 0.1;  // [m/s]
constexpr double kTicks = 6.0;
// A noisy wheel repeats itself once now and then, and never for a second.
constexpr int kStretches = 10;

/// [m] by which a stretch's travel departs from that at the speed of the run's first.
double departure(const SteadyWheels::Run& run, Wheel wheel, const StepReadings& stretch, double seconds) {
  return std::abs(stretch.travel[wheel] - run.first.travel[wheel] * seconds / run.seconds);
}

}  // namespace

SteadyWheels::SteadyWheels(const Vehicle& vehicle) {
  for (const Wheel wheel : kAllWheels) tick_[wheel] = std::abs(vehicle.calibratedMetresPerTick(wheel));
}

/// A counter rounds at both ends of a stretch, so that each of the two is known to a tick.
bool SteadyWheels::departs(const Run& run, Wheel wheel, const StepReadings& stretch, double seconds) const {
  return departure(run, wheel, stretch, seconds) > tick_[wheel] * (1.0 + seconds / run.seconds);
}

void SteadyWheels::add(const StepReadings& stretch, double seconds) {
  for (const Wheel wheel : kAllWheels) {
    Run& run = runs_[wheel];
    if (run.stretches == 0 || departs(run, wheel, stretch, seconds)) run = {stretch, seconds, 0};
    ++run.stretches;
  }
}

double SteadyWheels::leastChange(Wheel wheel, const StepReadings& stretch, double seconds) const {
  return std::max(
      {kSpeed, kShare * std::abs(stretch.travel[wheel]) / seconds, kTicks * tick_[wheel] / seconds});
}

bool SteadyWheels::isLeftBehind(Wheel wheel, const StepReadings& stretch, double seconds,
                                const PerWheel<bool>& ignored) const {
  if (runs_[wheel].stretches < kStretches) return false;
  const double change = leastChange(wheel, stretch, seconds);
  for (const Wheel other : kAllWheels) {
    if (other == wheel || ignored[other] || tick_[other] == 0.0) continue;
    if (departure(runs_[wheel], other, stretch, seconds) < change * seconds) return false;
  }
  return true;
}

}  // namespace bs_car_odometry
