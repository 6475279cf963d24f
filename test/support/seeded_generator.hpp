#pragma once

#include <cmath>
#include <iostream>
#include <random>

namespace bs_car_odometry::test_support {

/// Normal draws from a fixed seed, which is printed so that a failure can be repeated.
class SeededGenerator {
 public:
  explicit SeededGenerator(unsigned seed) : engine_(seed) { std::cout << "seed " << seed << "\n"; }

  /// A draw of N(0, variance).
  double normal(double variance) { return std::sqrt(variance) * distribution_(engine_); }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> distribution_;
};

}  // namespace bs_car_odometry::test_support
