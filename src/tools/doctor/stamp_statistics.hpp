#pragma once

#include "series.hpp"

#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/core/time.hpp"

#include <cstdint>
#include <optional>

namespace bs_car_odometry::tools::doctor {

/// What the stamps of one topic are like, counted message by message.
class StampStatistics {
 public:
  explicit StampStatistics(const InputLimits& limits) : limits_(limits) {}

  /// @param stamp  none when it is none
  /// @return true for a message that the odometry would take: stamped, later than the one before, and not
  ///         from the future
  bool add(std::optional<Time> stamp, Time record);

  std::uint64_t messages() const { return messages_; }
  std::uint64_t zero() const { return zero_; }      ///< stamp zero, or none at all
  std::uint64_t future() const { return future_; }  ///< stamp later than the record by over max_future
  std::uint64_t backwards() const { return backwards_; }
  std::uint64_t repeated() const { return repeated_; }
  Duration furthestBack() const { return furthest_back_; }

  std::uint64_t gaps() const { return gaps_; }               ///< intervals beyond max_gap
  double longestGap() const { return toSeconds(longest_); }  ///< [s]
  Time longestGapAt() const { return longest_at_; }

  double interval(double fraction) const { return intervals_.quantile(fraction); }  ///< [s] quantile
  double rate() const;  ///< [Hz] 1 / median interval; 0 for fewer than two messages
  double offset(double fraction) const { return offsets_.quantile(fraction); }  ///< [s] record less stamp
  bool hasOffset() const { return !offsets_.empty(); }

  const std::optional<Time>& first() const { return first_; }
  const std::optional<Time>& last() const { return last_; }
  double duration() const { return first_ ? toSeconds(*last_ - *first_) : 0.0; }  ///< [s]

 private:
  bool isAhead(Time stamp, Time record);
  bool follows(Time stamp);
  void noteInterval(Time stamp);

  InputLimits limits_;
  std::uint64_t messages_{0}, zero_{0}, future_{0}, backwards_{0}, repeated_{0}, gaps_{0};
  Duration furthest_back_{0};
  Duration longest_{0};
  Time longest_at_;
  EvenSample intervals_;
  EvenSample offsets_;
  std::optional<Time> first_;
  std::optional<Time> last_;
};

}  // namespace bs_car_odometry::tools::doctor
