#pragma once

#include <array>
#include <cstddef>

namespace bs_car_odometry::laboratory {

/// Probability of the published intervals of a mean NEES.
constexpr double kConfidence = 0.999;

/// Shares of a Gaussian within 1, 2 and 3 standard deviations of its mean: 68.3, 95.4, 99.7 %.
std::array<double, 3> sigmaShares();

/// Where a chi-square variable of `degrees` degrees of freedom stays below with those probabilities: the
/// squared radii of the 1, 2 and 3 sigma regions (3.53, 8.02, 14.16 for 3).
std::array<double, 3> sigmaRegions(double degrees);

struct Interval {
  double low{0.0};
  double high{0.0};
  bool holds(double value) const { return value >= low && value <= high; }
};

/// Where the mean of `count` independent chi-square variables lies with probability kConfidence.
Interval meanInterval(double degrees, std::size_t count);

/// Below which the mean of `count` independent chi-square variables lies with this probability.
double meanBelow(double degrees, std::size_t count, double probability);

}  // namespace bs_car_odometry::laboratory
