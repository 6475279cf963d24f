#include "bs_car_odometry/simulation/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace bs_car_odometry::simulation
