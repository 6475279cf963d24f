#pragma once

#include "bs_car_odometry/core/time.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace bs_car_odometry {

/// Readings of one axle's angle in order of time, whatever the order in which they came. Holds at least the
/// newest `capacity` readings and never more than twice that; allocates only when it is made.
class SteeringBuffer {
 public:
  enum class Inserted { kYes, kRepeated, kTooOld };

  explicit SteeringBuffer(std::size_t capacity = 1024);

  /// @param angle  [rad], as read: scale and offset may change
  Inserted insert(Time stamp, double angle);

  void clear() { readings_.clear(); }
  bool empty() const { return readings_.empty(); }

  /// Stamps of the oldest and the newest reading; none when empty.
  std::optional<Time> oldest() const;
  std::optional<Time> newest() const;

  /// Stamp of the newest reading that is not after `stamp`.
  std::optional<Time> newestUntil(Time stamp) const;

  /// Reading at `stamp` [rad]: between the readings around it, held before the first and after the last.
  /// Must not be empty.
  double angleAt(Time stamp) const;

 private:
  struct Reading {
    Time stamp;
    double angle;
  };
  using Iterator = std::vector<Reading>::const_iterator;

  /// First reading after `stamp`.
  Iterator firstAfter(Time stamp) const;
  void makeRoom();

  std::size_t capacity_;
  std::vector<Reading> readings_;
};

}  // namespace bs_car_odometry
