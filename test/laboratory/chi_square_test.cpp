#include "bs_car_odometry/laboratory/chi_square.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace bs_car_odometry::laboratory {
namespace {

TEST(SigmaRegions, holdTheSharesOfAGaussian) {
  // Tables give these to four digits.
  const std::array<double, 3> shares = sigmaShares();
  EXPECT_NEAR(shares[0], 0.6827, 5e-5);
  EXPECT_NEAR(shares[1], 0.9545, 5e-5);
  EXPECT_NEAR(shares[2], 0.9973, 5e-5);
  const std::array<double, 3> line = sigmaRegions(1.0);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(line[k], std::pow(static_cast<double>(k + 1), 2), 1e-9);
  const std::array<double, 3> space = sigmaRegions(3.0);
  EXPECT_NEAR(space[0], 3.527, 5e-4);
  EXPECT_NEAR(space[1], 8.025, 5e-4);
  EXPECT_NEAR(space[2], 14.156, 5e-4);
}

TEST(MeanInterval, isThatOfTheSumOfChiSquares) {
  // 200 runs: 2.46 to 3.60 for 3 degrees of freedom; 1,000: 2.75 to 3.26.
  const Interval few = meanInterval(3.0, 200);
  EXPECT_NEAR(few.low, 2.46, 0.005);
  EXPECT_NEAR(few.high, 3.60, 0.005);
  const Interval many = meanInterval(3.0, 1000);
  EXPECT_NEAR(many.low, 2.75, 0.005);
  EXPECT_NEAR(many.high, 3.26, 0.005);
  EXPECT_TRUE(many.holds(3.0));
  EXPECT_FALSE(many.holds(2.7));
  EXPECT_FALSE(many.holds(3.3));
}

}  // namespace
}  // namespace bs_car_odometry::laboratory
