#include "bs_car_odometry/simulation/wheel_encoder.hpp"

#include <cmath>

namespace bs_car_odometry::simulation {

std::int64_t WheelEncoder::read(double travel) {
  const Distribution& noise = settings_.noise;
  if (noise.scale() > 0.0)
    noise_ += noise.scale() * std::sqrt(std::abs(travel - travel_)) * random_.drawUnscaled(noise);
  travel_ = travel;
  if (settings_.metres_per_tick == 0.0) return settings_.start;
  const std::int64_t ticks = std::llround(measuredTravel() / settings_.metres_per_tick);
  // Unsigned, where passing the end is defined.
  const std::uint64_t counter =
      static_cast<std::uint64_t>(settings_.start) + static_cast<std::uint64_t>(ticks);
  return wrapCounter(static_cast<std::int64_t>(counter), settings_.counter_bits);
}

std::int64_t wrapCounter(std::int64_t counter, int bits) {
  if (bits <= 0 || bits >= 64) return counter;
  const std::uint64_t sign = std::uint64_t{1} << static_cast<unsigned>(bits - 1);
  const std::uint64_t low = static_cast<std::uint64_t>(counter) & (2U * sign - 1U);
  return static_cast<std::int64_t>((low ^ sign) - sign);
}

}  // namespace bs_car_odometry::simulation
