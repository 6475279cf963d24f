#include "counter_watch.hpp"

#include "bs_car_odometry/core/wheel_counters.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace bs_car_odometry::tools::doctor {

namespace {

constexpr std::array<int, 9> kWidths{8, 10, 12, 14, 15, 16, 20, 24, 32};
/// What the odometry takes for plausible: half as fast again as max_speed, and 10 ms of jitter.
constexpr double kPlausibleExcess = 1.5;
constexpr double kStampJitter = 0.01;
/// A step of so many times the usual ones, and of so many ticks, is looked at.
constexpr double kStrange = 4.0;
constexpr double kFewTicks = 32.0;
constexpr double kForgotten = 0.98;  ///< of the usual step, a message

}  // namespace

CounterWatch::CounterWatch(int bits, double metres_per_tick, double max_speed)
    : bits_(bits), metres_per_tick_(std::abs(metres_per_tick)), max_speed_(max_speed) {}

double CounterWatch::longestPlausible(Duration interval) const {
  return max_speed_ * (kPlausibleExcess * toSeconds(interval) + kStampJitter) / metres_per_tick_;
}

std::int64_t CounterWatch::add(std::int64_t counter, Time stamp) {
  lowest_ = std::min(lowest_, counter);
  highest_ = std::max(highest_, counter);
  const std::optional<std::int64_t> before = last_;
  const Time stamp_before = last_stamp_;
  last_ = counter;
  last_stamp_ = stamp;
  if (!before) return 0;

  const std::int64_t difference = counterDifference(counter, *before, bits_);
  const double size = std::abs(static_cast<double>(difference));
  if (difference != counterDifference(counter, *before, 0)) ++wraps_;
  const bool plausible = size <= longestPlausible(stamp - stamp_before);
  const bool explained = size > std::max(kStrange * usual_, kFewTicks) && explain(counter, size, stamp);
  if (plausible && !explained) {
    usual_ = std::max(kForgotten * usual_, size);
  } else if (!explained) {
    ++jumps_;
    jump_at_ = stamp;
  }
  return plausible ? difference : 0;
}

/// A wrap at a narrower width or a restart at zero? A large step may also be a car that starts.
bool CounterWatch::explain(std::int64_t counter, double size, Time stamp) {
  const double near = std::max(kStrange * usual_, 4.0);
  for (const int width : kWidths) {
    const double range = std::ldexp(1.0, width);
    if ((bits_ != 0 && width >= bits_) || near > 0.25 * range || std::abs(size - range) > near) continue;
    found_bits_ = width;
    return true;
  }
  if (std::abs(static_cast<double>(counter)) > near || size < 10.0 * near) return false;
  ++restarts_;
  restart_at_ = stamp;
  return true;
}

bool CounterWatch::exceedsWidth() const {
  if (bits_ <= 0 || bits_ >= 63 || highest_ < lowest_) return false;
  const std::int64_t range = std::int64_t{1} << bits_;
  const bool is_signed = lowest_ < 0;
  return is_signed ? lowest_ < -range / 2 || highest_ >= range / 2 : highest_ >= range;
}

}  // namespace bs_car_odometry::tools::doctor
