#pragma once

#include <cstdint>

namespace bs_car_odometry::simulation {

/// Random numbers that are the same on every platform: SplitMix64 (Steele, Lea and Flood, OOPSLA 2014) and
/// Box-Muller on its bits. The distributions of <random> are left to the implementation, so they are not
/// used.
class Random {
 public:
  /// Streams of one seed are independent of each other: each sensor draws from its own, and reading one
  /// sensor more often leaves the others as they were.
  Random(std::uint64_t seed, std::uint64_t stream);

  std::uint64_t bits();

  /// Uniform in (0, 1].
  double uniform() { return static_cast<double>((bits() >> 11U) + 1U) * 0x1.0p-53; }

  /// Standard normal.
  double normal();

 private:
  std::uint64_t state_;
  double spare_{0.0};  ///< Box-Muller gives two at a time
  bool has_spare_{false};
};

}  // namespace bs_car_odometry::simulation
