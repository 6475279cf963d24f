#pragma once

#include "bs_car_odometry/core/time.hpp"

#include <cstdint>
#include <limits>
#include <optional>

namespace bs_car_odometry::tools::doctor {

/// How one wheel's counter behaves, message by message.
class CounterWatch {
 public:
  /// @param bits  `encoders/counter_bits`  @param metres_per_tick  with its sign  @param max_speed  [m/s]
  CounterWatch(int bits, double metres_per_tick, double max_speed);

  /// @return ticks since the reading before; 0 for the first one and for a jump that the wheel cannot make
  std::int64_t add(std::int64_t counter, Time stamp);

  std::uint64_t wraps() const { return wraps_; }  ///< at the configured width, as they should be
  std::uint64_t jumps() const { return jumps_; }  ///< that the wheel cannot make, and nothing below explains
  std::uint64_t restarts() const { return restarts_; }  ///< from anywhere to zero
  Time restartAt() const { return restart_at_; }        ///< the last one
  Time jumpAt() const { return jump_at_; }              ///< the last one
  /// Width at which it wraps although another one is configured; 0: none.
  int foundBits() const { return found_bits_; }
  bool exceedsWidth() const;
  std::int64_t lowest() const { return lowest_; }
  std::int64_t highest() const { return highest_; }

 private:
  bool explain(std::int64_t counter, double size, Time stamp);
  double longestPlausible(Duration interval) const;

  int bits_;
  double metres_per_tick_;
  double max_speed_;
  std::optional<std::int64_t> last_;
  Time last_stamp_;
  double usual_{0.0};  ///< [ticks] the most of the last steps, slowly forgotten
  std::uint64_t wraps_{0}, jumps_{0}, restarts_{0};
  Time restart_at_, jump_at_;
  int found_bits_{0};
  std::int64_t lowest_{std::numeric_limits<std::int64_t>::max()};
  std::int64_t highest_{std::numeric_limits<std::int64_t>::min()};
};

}  // namespace bs_car_odometry::tools::doctor
