#pragma once

#include <chrono>
#include <cstdint>

namespace bs_car_odometry {

/// The core's own time: nanoseconds since the epoch in 64 bits, signed. `ros::Time` throws when arithmetic
/// leaves its 32-bit range, so stamps become this type where messages enter and go back where they leave.
struct Clock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<Clock>;
  static constexpr bool is_steady = false;
};

using Duration = Clock::duration;
using Time = Clock::time_point;

struct TimeSpan {
  Time begin;
  Time end;

  bool contains(Time stamp) const { return begin <= stamp && stamp <= end; }
};

constexpr Time timeFromNanoseconds(std::int64_t nanoseconds) { return Time(Duration(nanoseconds)); }

/// [s]
constexpr double toSeconds(Duration duration) { return static_cast<double>(duration.count()) * 1e-9; }

/// Nearest nanosecond; `seconds` within +/-9.2e9 [s].
constexpr Duration durationFromSeconds(double seconds) {
  return Duration(static_cast<std::int64_t>(seconds * 1e9 + (seconds < 0.0 ? -0.5 : 0.5)));
}

}  // namespace bs_car_odometry
