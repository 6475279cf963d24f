// The random numbers of the particles: known answers of the generator, moments of what is drawn from it.
#include "bs_car_odometry/core/particle_draws.hpp"
#include "bs_car_odometry/core/held_errors.hpp"
#include "bs_car_odometry/core/particle_kernels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace bs_car_odometry {
namespace {

constexpr std::uint64_t kSeed = 20;

/// From the test vectors of the authors' library, Random123.
TEST(Philox, knownAnswers) {
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (PhiloxCounter{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  constexpr std::uint32_t kOnes = 0xffffffff;
  EXPECT_EQ(philox({kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}),
            (PhiloxCounter{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (PhiloxCounter{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(Philox, blocksAreTheGeneratorItself) {
  const std::vector<std::uint32_t> particles{0, 1, 7, 1000000};
  std::array<BitBlock, 4> bits;
  kernels::randomBits({0x123456789abcdefULL, 4, 5, 6, 7}, particles.data(), particles.size(), bits);
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const PhiloxCounter expected = philox({particles[i], 4, 5, 0x00060007}, {0x89abcdef, 0x01234567});
    for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(bits[k][i], expected[k]);
  }
}

TEST(Kernels, sineAndCosine) {
  DoubleBlock angles;
  for (std::size_t i = 0; i < angles.size(); ++i)
    angles[i] = std::pow(10.0, static_cast<double>(i % 64) / 8.0) * (i % 2 == 0 ? 1e-3 : -1e-3);
  FloatBlock sines;
  FloatBlock cosines;
  kernels::sinesAndCosines(angles, angles.size(), sines, cosines);
  for (std::size_t i = 0; i < angles.size(); ++i) {
    // Two units in the last place of a float near 1.
    EXPECT_NEAR(sines[i], std::sin(angles[i]), 1.2e-7) << angles[i];
    EXPECT_NEAR(cosines[i], std::cos(angles[i]), 1.2e-7) << angles[i];
  }
}

TEST(Kernels, chords) {
  FloatBlock turn;
  for (std::size_t i = 0; i < turn.size(); ++i)
    turn[i] = kernels::kLargeTurn * (static_cast<float>(i) / 128.0F - 1.0F);
  FloatBlock series;
  FloatBlock quotient;
  kernels::chords(turn, turn.size(), series);
  kernels::chordsOfLargeTurns(turn, turn.size(), quotient);
  for (std::size_t i = 0; i < turn.size(); ++i) {
    const double half = 0.5 * static_cast<double>(turn[i]);
    const double expected = half == 0.0 ? 1.0 : std::sin(half) / half;
    EXPECT_NEAR(series[i], expected, 3e-7) << turn[i];
    EXPECT_NEAR(quotient[i], expected, 3e-7) << turn[i];
  }
}

std::vector<double> draws(const Distribution& distribution, std::uint32_t steps) {
  std::vector<std::uint32_t> particles(kParticleBlock);
  std::iota(particles.begin(), particles.end(), 0U);
  std::vector<double> values;
  FloatBlock block;
  for (std::uint32_t step = 0; step < steps; ++step) {
    draw(distribution, {kSeed, step, 3}, particles.data(), particles.size(), block);
    values.insert(values.end(), block.begin(), block.end());
  }
  return values;
}

double meanPower(const std::vector<double>& values, int power) {
  double sum = 0.0;
  for (const double value : values) sum += std::pow(value, power);
  return sum / static_cast<double>(values.size());
}

class Draws : public testing::TestWithParam<Distribution> {};

TEST_P(Draws, haveTheMomentsOfTheDistribution) {
  const Distribution& distribution = GetParam();
  const std::vector<double> values = draws(distribution, 4000);
  const auto n = static_cast<double>(values.size());
  std::cout << "seed " << kSeed << ", " << values.size() << " draws\n";
  const double variance = distribution.variance();
  // Four standard errors: of the mean, of the variance, and, with the sample's own eighth moment, of the
  // fourth.
  EXPECT_NEAR(meanPower(values, 1), 0.0, 4.0 * std::sqrt(variance / n));
  EXPECT_NEAR(meanPower(values, 2), variance,
              4.0 * variance * std::sqrt((distribution.kurtosis() - 1.0) / n));
  const double fourth = distribution.kurtosis() * variance * variance;
  EXPECT_NEAR(meanPower(values, 4), fourth, 4.0 * std::sqrt((meanPower(values, 8) - fourth * fourth) / n));
  EXPECT_NEAR(meanPower(values, 3), 0.0, 4.0 * std::sqrt(meanPower(values, 6) / n));
  const double limit = distribution.truncation();
  for (const double value : values) ASSERT_LE(std::abs(value), limit * (1.0 + 1e-6));
}

INSTANTIATE_TEST_SUITE_P(Shapes, Draws,
                         testing::Values(Distribution(0.3), Distribution::gaussian(0.3, 0.4),
                                         Distribution::gaussian(2.0, 1.0), Distribution::uniform(0.1),
                                         Distribution::triangular(0.1), Distribution::studentT(0.2, 12.0),
                                         Distribution::studentT(0.2, 1.0, 0.5)));

TEST(Draws, standardisedOnesHaveVarianceOne) {
  const std::vector<std::uint32_t> particles{0, 1, 2};
  const Distribution distribution = Distribution::uniform(0.1);
  FloatBlock plain;
  FloatBlock standardised;
  draw(distribution, {kSeed, 1, 1}, particles.data(), 3, plain);
  drawStandardised(distribution, {kSeed, 1, 1}, particles.data(), 3, standardised);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(standardised[i], plain[i] / distribution.std(), 1e-6);
  drawStandardised(Distribution(0.0), {kSeed, 1, 1}, particles.data(), 3, standardised);
  EXPECT_EQ(standardised[0], 0.0F);
}

/// Variance of the error's integral over a drive [rad^2 m^2].
double integralVariance(const Distribution& distribution, double length, double step, double drive) {
  constexpr std::size_t kParticles = 20 * kParticleBlock;
  HeldErrors held(distribution, length, kParticles);
  std::vector<double> integral(kParticles);
  FloatBlock mean;
  for (std::size_t first = 0; first < kParticles; first += kParticleBlock)
    held.begin({kSeed, 0, 0}, first, kParticleBlock);
  const auto steps = static_cast<std::uint32_t>(std::lround(drive / step));
  for (std::uint32_t k = 1; k <= steps; ++k) {
    const HeldErrors::Step taken = held.take(step);
    for (std::size_t first = 0; first < kParticles; first += kParticleBlock) {
      held.advance(taken, {kSeed, k, 0}, first, kParticleBlock, mean);
      for (std::size_t i = 0; i < kParticleBlock; ++i) integral[first + i] += step * mean[i];
    }
  }
  return meanPower(integral, 2);
}

class HeldErrorsOver : public testing::TestWithParam<double> {};

/// Pieces of one length and random start: l D - l^2/3 of the variance for a drive D of whole lengths l,
/// whatever the steps; the last ones hold up to 600 draws.
TEST_P(HeldErrorsOver, stepsOfThisLengthLeaveTheSameVariance) {
  const Distribution distribution = Distribution::uniform(0.01);
  const double length = 0.1;
  const double drive = 60.0;
  const double expected = distribution.variance() * (length * drive - length * length / 3.0);
  // Four standard errors of the variance of 5120 nearly Gaussian numbers.
  EXPECT_NEAR(integralVariance(distribution, length, GetParam(), drive) / expected, 1.0,
              4.0 * std::sqrt(2.0 / 5120.0));
}

INSTANTIATE_TEST_SUITE_P(Steps, HeldErrorsOver, testing::Values(0.01, 0.03, 0.12, 0.75, 3.0, 20.0, 60.0));

TEST(HeldErrors, lastForALength) {
  HeldErrors held(Distribution(1.0), 1.0, kParticleBlock);
  held.begin({kSeed, 0, 0}, 0, kParticleBlock);
  FloatBlock before;
  FloatBlock after;
  held.advance(held.take(0.25), {kSeed, 1, 0}, 0, kParticleBlock, before);
  held.advance(held.take(0.25), {kSeed, 2, 0}, 0, kParticleBlock, after);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < kParticleBlock; ++i) kept += before[i] == after[i] ? 1 : 0;
  // Those whose next draw comes after 0.5 m. The mean over a step is of the old error where that ends within.
  EXPECT_EQ(kept, kParticleBlock / 2);
}

TEST(HeldErrors, absurdStepsEnd) {
  HeldErrors held(Distribution(1.0), 1e-3, kParticleBlock);
  held.begin({kSeed, 0, 0}, 0, kParticleBlock);
  FloatBlock mean;
  for (const double travel : {1e-40, 1e-3, 1.0, 1e9, 1e30}) {
    held.advance(held.take(travel), {kSeed, 1, 0}, 0, kParticleBlock, mean);
    for (const float value : mean) ASSERT_TRUE(std::isfinite(value)) << travel;
  }
}

}  // namespace
}  // namespace bs_car_odometry
