#include "damage.hpp"

#include <cmath>
#include <random>
#include <utility>

namespace bs_car_odometry::drives {

void scaleTravel(std::vector<Sample>& drive, Wheel wheel, double factor, double from, double until) {
  std::int64_t before = drive.front().ticks[wheel];
  double counter = static_cast<double>(before);
  for (Sample& sample : drive) {
    const std::int64_t now = sample.ticks[wheel];
    const bool faulty = sample.time > from && sample.time <= until;
    counter += (faulty ? factor : 1.0) * static_cast<double>(now - before);
    before = now;
    sample.ticks[wheel] = std::llround(counter);
  }
}

void freezeSpeed(std::vector<Sample>& drive, Wheel wheel, double from) {
  std::size_t first = 1;
  while (drive[first].time < from) ++first;
  const Sample before = drive[first - 1];
  const Sample at = drive[first];
  const double speed = static_cast<double>(at.ticks[wheel] - before.ticks[wheel]) / (at.time - before.time);
  for (std::size_t i = first; i < drive.size(); ++i)
    drive[i].ticks[wheel] = at.ticks[wheel] + std::llround(speed * (drive[i].time - at.time));
}

void swapCounters(std::vector<Sample>& drive, Wheel a, Wheel b) {
  for (Sample& sample : drive) std::swap(sample.ticks[a], sample.ticks[b]);
}

void freezeAngle(std::vector<Sample>& drive, Axle axle, double from) {
  double held = drive.front().steering[axle];
  for (Sample& sample : drive) {
    if (sample.time <= from) held = sample.steering[axle];
    sample.steering[axle] = held;
  }
}

void offsetAngle(std::vector<Sample>& drive, Axle axle, double offset, double from) {
  for (Sample& sample : drive)
    if (sample.time > from) sample.steering[axle] += offset;
}

void addSpikes(std::vector<Sample>& drive, double probability, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform;
  std::uniform_int_distribution<std::int64_t> size(10000, 1000000);
  for (Sample& sample : drive)
    for (std::int64_t& counter : sample.ticks.values)
      if (uniform(random) < probability) counter += (uniform(random) < 0.5 ? -1 : 1) * size(random);
}

}  // namespace bs_car_odometry::drives
