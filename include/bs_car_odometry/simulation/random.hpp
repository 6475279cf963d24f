#pragma once

#include "bs_car_odometry/core/distribution.hpp"

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

  /// An error of this distribution.
  double draw(const Distribution& distribution) { return distribution.scale() * drawUnscaled(distribution); }

  /// An error divided by the scale of its distribution, for errors that grow with the distance: the product
  /// with the scale stays within the truncation. One normal number for a Gaussian.
  double drawUnscaled(const Distribution& distribution);

 private:
  double drawUntruncated(const Distribution& distribution);
  double studentT(double degrees_of_freedom);

  std::uint64_t state_;
  double spare_{0.0};  ///< Box-Muller gives two at a time
  bool has_spare_{false};
};

}  // namespace bs_car_odometry::simulation
