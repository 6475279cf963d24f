#include "bs_car_odometry/core/particle_draws.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

namespace {

/// Truncation leaves more than a quarter of the draws (Distribution), so that this many attempts fail less
/// often than a computer does.
constexpr std::uint16_t kMostAttempts = 200;

using Bits = std::array<BitBlock, 4>;

/// In (0, 1], to 32 bits.
double unitNumber(std::uint32_t bits) { return (static_cast<double>(bits) + 1.0) * 0x1p-32; }

/// Student's t in one go: R. W. Bailey, "Polar generation of random variates with the t-distribution",
/// Mathematics of Computation 62 (1994), in the form of Box and Muller.
void drawStudentT(double degrees_of_freedom, const Bits& bits, std::size_t count, FloatBlock& values) {
  const double n = degrees_of_freedom;
  for (std::size_t i = 0; i < count; ++i) {
    const double radius = std::sqrt(n * std::expm1(-2.0 / n * std::log(unitNumber(bits[0][i]))));
    values[i] = static_cast<float>(radius * std::cos(2.0 * M_PI * unitNumber(bits[1][i])));
  }
}

/// Of scale 1, not truncated.
void drawShape(const Distribution& distribution, const Bits& bits, std::size_t count, FloatBlock& values) {
  switch (distribution.shape()) {
    case Distribution::Shape::kGaussian:
      return kernels::normals(bits[0], bits[1], count, values);
    case Distribution::Shape::kUniform:
      return kernels::uniforms(bits[0], count, values);
    case Distribution::Shape::kTriangular: {
      FloatBlock other;
      kernels::uniforms(bits[0], count, values);
      kernels::uniforms(bits[1], count, other);
      for (std::size_t i = 0; i < count; ++i) values[i] = 0.5F * (values[i] + other[i]);
      return;
    }
    case Distribution::Shape::kStudentT:
      return drawStudentT(distribution.degreesOfFreedom(), bits, count, values);
  }
}

/// Draws again what lies outside, until nothing does.
void redrawOutside(const Distribution& distribution, double limit, DrawNumber number,
                   const std::uint32_t* particles, std::size_t count, FloatBlock& values) {
  Bits bits;
  FloatBlock again;
  BitBlock outside;
  BitBlock place;
  for (number.attempt = 1; number.attempt < kMostAttempts; ++number.attempt) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (std::abs(values[i]) <= limit) continue;
      outside[n] = particles[i];
      place[n++] = static_cast<std::uint32_t>(i);
    }
    if (n == 0) return;
    kernels::randomBits(number, outside.data(), n, bits);
    drawShape(distribution, bits, n, again);
    for (std::size_t i = 0; i < n; ++i) values[place[i]] = again[i];
  }
  const auto most = static_cast<float>(limit);
  for (std::size_t i = 0; i < count; ++i) values[i] = std::clamp(values[i], -most, most);
}

void drawScaled(const Distribution& distribution, double scale, DrawNumber number,
                const std::uint32_t* particles, std::size_t count, FloatBlock& values) {
  if (!(scale > 0.0)) {
    std::fill_n(values.begin(), count, 0.0F);
    return;
  }
  Bits bits;
  number.attempt = 0;
  kernels::randomBits(number, particles, count, bits);
  drawShape(distribution, bits, count, values);
  if (distribution.truncation() < Distribution::kNotTruncated)
    redrawOutside(distribution, distribution.truncation() / distribution.scale(), number, particles, count,
                  values);
  const auto factor = static_cast<float>(scale);
  for (std::size_t i = 0; i < count; ++i) values[i] *= factor;
}

}  // namespace

void draw(const Distribution& distribution, const DrawNumber& number, const std::uint32_t* particles,
          std::size_t count, FloatBlock& values) {
  drawScaled(distribution, distribution.scale(), number, particles, count, values);
}

void drawStandardised(const Distribution& distribution, const DrawNumber& number,
                      const std::uint32_t* particles, std::size_t count, FloatBlock& values) {
  const double std = distribution.std();
  drawScaled(distribution, std > 0.0 ? distribution.scale() / std : 0.0, number, particles, count, values);
}

}  // namespace bs_car_odometry
