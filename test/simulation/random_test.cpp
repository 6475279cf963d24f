#include "bs_car_odometry/simulation/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <vector>

namespace bs_car_odometry::simulation {
namespace {

// Bits computed independently (Python integers) from the definition of SplitMix64.
TEST(Random, givesTheSameBitsOnEveryPlatform) {
  Random random(1, 0);
  EXPECT_EQ(random.bits(), 0xb18a02f46d8d86c3ULL);
  EXPECT_EQ(random.bits(), 0xf8c5b62c83f707e8ULL);
}

TEST(Random, seedsAndStreamsDiffer) {
  const std::uint64_t first = Random(1, 0).bits();
  EXPECT_EQ(first, Random(1, 0).bits());
  EXPECT_NE(first, Random(2, 0).bits());
  EXPECT_NE(first, Random(1, 1).bits());
  EXPECT_NE(Random(1, 2).bits(), Random(2, 1).bits());
}

TEST(Random, uniformStaysWithinItsBoundsAndFillsThem) {
  Random random(7, 0);
  double lowest = 1.0;
  double highest = 0.0;
  for (int i = 0; i < 100000; ++i) {
    const double u = random.uniform();
    ASSERT_GT(u, 0.0);
    ASSERT_LE(u, 1.0);
    lowest = std::fmin(lowest, u);
    highest = std::fmax(highest, u);
  }
  EXPECT_LT(lowest, 1e-4);
  EXPECT_GT(highest, 1.0 - 1e-4);
}

// Moments of 1e6 draws within five of their standard errors: 1, sqrt(2), sqrt(15), sqrt(96) thousandths.
TEST(Random, normalHasTheMomentsOfTheNormalDistribution) {
  constexpr int kDraws = 1000000;
  Random random(11, 3);
  double sums[4] = {};
  double neighbours = 0.0;
  double previous = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double z = random.normal();
    sums[0] += z;
    sums[1] += z * z;
    sums[2] += z * z * z;
    sums[3] += z * z * z * z;
    neighbours += z * previous;
    previous = z;
  }
  EXPECT_NEAR(sums[0] / kDraws, 0.0, 0.005);
  EXPECT_NEAR(sums[1] / kDraws, 1.0, 0.0071);
  EXPECT_NEAR(sums[2] / kDraws, 0.0, 0.0194);
  EXPECT_NEAR(sums[3] / kDraws, 3.0, 0.049);
  EXPECT_NEAR(neighbours / kDraws, 0.0, 0.005);
}

/// A distribution with its cumulative distribution function F in units of the scale.
struct Case {
  const char* name;
  Distribution distribution;
  std::function<double(double)> cdf;
  bool has_eighth_moment;
};

double normalCdf(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }
double cauchyCdf(double x) { return 0.5 + std::atan(x) / std::acos(-1.0); }

/// Student's t with 3 and 5 degrees of freedom, y = x / sqrt(dof).
double t3Cdf(double x) {
  const double y = x / std::sqrt(3.0);
  return 0.5 + (y / (1.0 + y * y) + std::atan(y)) / std::acos(-1.0);
}
double t5Cdf(double x) {
  const double y = x / std::sqrt(5.0);
  const double r = 1.0 / (1.0 + y * y);
  return 0.5 + (y * r * (1.0 + 2.0 / 3.0 * r) + std::atan(y)) / std::acos(-1.0);
}
double triangularCdf(double x) {
  return x < 0.0 ? 0.5 * (1.0 + x) * (1.0 + x) : 1.0 - 0.5 * (1.0 - x) * (1.0 - x);
}

/// F between the limits, brought to 0..1.
std::function<double(double)> within(double limit, double (*cdf)(double)) {
  return [=](double x) { return (cdf(x) - cdf(-limit)) / (cdf(limit) - cdf(-limit)); };
}

std::vector<Case> everyDistribution() {
  const auto uniformCdf = [](double x) { return 0.5 * (1.0 + x); };
  return {
      {"gaussian", Distribution::gaussian(0.02), normalCdf, true},
      {"truncated gaussian", Distribution::gaussian(0.02, 0.03), within(1.5, normalCdf), true},
      {"uniform", Distribution::uniform(0.02), uniformCdf, true},
      {"triangular", Distribution::triangular(0.02), triangularCdf, true},
      {"t of 5", Distribution::studentT(0.02, 5.0), t5Cdf, false},
      {"truncated t of 3", Distribution::studentT(0.02, 3.0, 0.2), within(10.0, t3Cdf), true},
      {"truncated t of 1", Distribution::studentT(0.02, 1.0, 0.01), within(0.5, cauchyCdf), true},
  };
}

constexpr int kDraws = 1000000;
constexpr std::uint64_t kSeed = 21;

std::vector<double> drawsOf(const Distribution& distribution) {
  std::cout << "seed " << kSeed << "\n";
  Random random(kSeed, 0);
  std::vector<double> draws(kDraws);
  for (double& draw : draws) draw = random.draw(distribution);
  return draws;
}

double moment(const std::vector<double>& draws, double unit, int power) {
  double sum = 0.0;
  for (const double draw : draws) sum += std::pow(draw / unit, power);
  return sum / static_cast<double>(draws.size());
}

// Each within five standard errors of 1e6 draws: of the mean std, of the variance std^2 sqrt(kurtosis - 1),
// both over sqrt(1e6); of the fourth moment from the eighth of the draws themselves.
TEST(Draws, haveTheMomentsOfTheirDistribution) {
  const double five_errors = 5.0 / std::sqrt(kDraws);
  for (const Case& c : everyDistribution()) {
    SCOPED_TRACE(c.name);
    const std::vector<double> draws = drawsOf(c.distribution);
    const double std = c.distribution.std();
    const double kurtosis = c.distribution.kurtosis();
    EXPECT_NEAR(moment(draws, std, 1), 0.0, five_errors);
    EXPECT_NEAR(moment(draws, std, 2), 1.0, five_errors * std::sqrt(kurtosis - 1.0));
    if (!c.has_eighth_moment) continue;
    const double eighth = moment(draws, std, 8);
    EXPECT_NEAR(moment(draws, std, 4), kurtosis, five_errors * std::sqrt(eighth - kurtosis * kurtosis));
  }
}

// Kolmogorov and Smirnov: sup |F_n - F| sqrt(n) is above 2.23 once in 10,000 seeds.
TEST(Draws, haveTheShapeOfTheirDistribution) {
  for (const Case& c : everyDistribution()) {
    std::vector<double> draws = drawsOf(c.distribution);
    std::sort(draws.begin(), draws.end());
    double largest = 0.0;
    for (std::size_t i = 0; i < draws.size(); ++i) {
      const double share = (static_cast<double>(i) + 0.5) / kDraws;
      largest = std::max(largest, std::abs(c.cdf(draws[i] / c.distribution.scale()) - share));
    }
    EXPECT_LT(largest * std::sqrt(kDraws), 2.23) << c.name;
  }
}

TEST(Draws, neverExceedTheirTruncation) {
  for (const Case& c : everyDistribution()) {
    const bool bounded = c.distribution.shape() == Distribution::Shape::kUniform ||
                         c.distribution.shape() == Distribution::Shape::kTriangular;
    const double limit = bounded ? c.distribution.scale() : c.distribution.truncation();
    for (const double draw : drawsOf(c.distribution)) ASSERT_LE(std::abs(draw), limit) << c.name;
  }
}

// Drives of a seed that were recorded stay what they were.
TEST(Draws, ofAGaussianAreItsStandardDeviationTimesTheNormalNumbers) {
  Random normal(5, 0);
  Random drawn(5, 0);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(drawn.draw(0.03), 0.03 * normal.normal());
}

}  // namespace
}  // namespace bs_car_odometry::simulation
