#pragma once

#include <cstdint>

namespace bs_car_odometry {

/// Ticks from `before` to `now` of a counter that wraps modulo 2^bits, signed or unsigned alike: the unsigned
/// difference in that width, read as signed. Right as long as the wheel turns by less than half the range.
/// @param bits  1 to 63; 0 for a counter that never wraps.
constexpr std::int64_t counterDifference(std::int64_t now, std::int64_t before, int bits) {
  const std::uint64_t difference = static_cast<std::uint64_t>(now) - static_cast<std::uint64_t>(before);
  if (bits <= 0 || bits >= 64) return static_cast<std::int64_t>(difference);
  const std::uint64_t half = std::uint64_t{1} << (bits - 1);
  const std::uint64_t mask = (half << 1) - 1;
  return static_cast<std::int64_t>(((difference + half) & mask)) - static_cast<std::int64_t>(half);
}

}  // namespace bs_car_odometry
