#include "bs_car_odometry/simulation/random.hpp"

#include <cmath>

namespace bs_car_odometry::simulation {

namespace {

constexpr std::uint64_t kGamma = 0x9e3779b97f4a7c15ULL;  // 2^64 / golden ratio, odd

std::uint64_t mix(std::uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31U);
}

}  // namespace

// All streams walk the same cycle of 2^64 states from places that two rounds of mixing scatter.
Random::Random(std::uint64_t seed, std::uint64_t stream)
    : state_(mix(mix(seed + kGamma) + kGamma * (stream + 1U))) {}

std::uint64_t Random::bits() {
  state_ += kGamma;
  return mix(state_);
}

double Random::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  constexpr double kTwoPi = 6.283185307179586476925;
  const double radius = std::sqrt(-2.0 * std::log(uniform()));
  const double angle = kTwoPi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

}  // namespace bs_car_odometry::simulation
