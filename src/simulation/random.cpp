#include "bs_car_odometry/simulation/random.hpp"

#include <cmath>

namespace bs_car_odometry::simulation {

namespace {

constexpr double kTwoPi = 6.283185307179586476925;
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
  const double radius = std::sqrt(-2.0 * std::log(uniform()));
  const double angle = kTwoPi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

double Random::drawUnscaled(const Distribution& distribution) {
  // What lies outside is drawn anew: at worst (Cauchy, half a scale) 3 draws in 10 are inside.
  for (;;) {
    const double draw = drawUntruncated(distribution);
    if (!(std::abs(distribution.scale() * draw) > distribution.truncation())) return draw;
  }
}

double Random::drawUntruncated(const Distribution& distribution) {
  switch (distribution.shape()) {
    case Distribution::Shape::kUniform:
      return 2.0 * uniform() - 1.0;
    case Distribution::Shape::kTriangular: {
      const double first = uniform();
      return first - uniform();
    }
    case Distribution::Shape::kStudentT:
      return studentT(distribution.degreesOfFreedom());
    case Distribution::Shape::kGaussian:
      break;
  }
  return normal();
}

/// Polar method of Bailey (Mathematics of Computation 62, 1994), Box-Muller with the t's radius:
/// sqrt(dof (u^(-2/dof) - 1)) cos(2 pi v).
double Random::studentT(double degrees_of_freedom) {
  const double excess = std::expm1(-2.0 / degrees_of_freedom * std::log(uniform()));
  const double radius = std::sqrt(degrees_of_freedom * excess);
  return radius * std::cos(kTwoPi * uniform());
}

}  // namespace bs_car_odometry::simulation
