#include "bs_car_odometry/simulation/wheel_encoder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace bs_car_odometry::simulation {
namespace {

WheelEncoder encoder(const WheelEncoder::Settings& settings, std::uint64_t seed = 1) {
  return {settings, Random(seed, 10)};
}

TEST(WrapCounter, keepsTheLowBitsAsASignedNumber) {
  EXPECT_EQ(wrapCounter(127, 8), 127);
  EXPECT_EQ(wrapCounter(128, 8), -128);
  EXPECT_EQ(wrapCounter(-129, 8), 127);
  EXPECT_EQ(wrapCounter(256 * 5 + 3, 8), 3);
  EXPECT_EQ(wrapCounter((std::int64_t{1} << 31), 32), -(std::int64_t{1} << 31));
  EXPECT_EQ(wrapCounter(INT64_MIN, 0), INT64_MIN);
  EXPECT_EQ(wrapCounter(INT64_MAX, 64), INT64_MAX);
}

TEST(WrapCounter, differencesSurviveTheWrap) {
  for (int bits : {8, 16, 32, 63}) {
    const std::int64_t before = wrapCounter(INT64_MAX - 40, bits);
    const std::int64_t after = wrapCounter(INT64_MAX - 3, bits);
    EXPECT_EQ(wrapCounter(static_cast<std::int64_t>(static_cast<std::uint64_t>(after) -
                                                    static_cast<std::uint64_t>(before)),
                          bits),
              37)
        << bits;
  }
}

TEST(WheelEncoder, countsForwardTravelAndBackwardsWhenMountedBackwards) {
  EXPECT_EQ(encoder({1e-4, 0.0, 32, 0}).read(1.0), 10000);
  EXPECT_EQ(encoder({-1e-4, 0.0, 32, 0}).read(1.0), -10000);
  EXPECT_EQ(encoder({1e-4, 0.0, 32, 500}).read(-0.01), 400);
}

// True travel = k zeta ticks: a wheel that is 2 % larger gives fewer ticks.
TEST(WheelEncoder, aLargerWheelCountsLess) { EXPECT_EQ(encoder({1.02e-4, 0.0, 32, 0}).read(1.02), 10000); }

TEST(WheelEncoder, roundsTheRunningSumAndNotEachStep) {
  WheelEncoder wheel = encoder({1e-4, 0.0, 32, 0});
  for (int i = 1; i <= 1000; ++i) {
    const double travel = 0.37e-4 * i;
    EXPECT_LE(std::abs(1e-4 * static_cast<double>(wheel.read(travel)) - travel), 0.5001e-4);
  }
}

TEST(WheelEncoder, wrapsAtItsBits) {
  WheelEncoder wheel = encoder({1e-4, 0.0, 16, 32767});
  EXPECT_EQ(wheel.read(0.0), 32767);
  EXPECT_EQ(wheel.read(1e-4), -32768);
}

TEST(WheelEncoder, a64BitCounterWrapsToo) {
  EXPECT_EQ(encoder({1e-4, 0.0, 64, INT64_MAX}).read(1e-4), INT64_MIN);
}

TEST(WheelEncoder, staysWithoutAnEncoder) { EXPECT_EQ(encoder({0.0, 0.005, 32, 7}).read(3.0), 7); }

TEST(WheelEncoder, isQuietWhenStanding) {
  WheelEncoder wheel = encoder({1e-6, 0.005, 32, 0});
  const std::int64_t counter = wheel.read(0.5);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(wheel.read(0.5), counter);
}

// Var = c^2 |S|, whatever the number of readings; 20000 drives, relative standard error 1 %.
TEST(WheelEncoder, noiseGrowsWithDistanceWhateverTheRate) {
  constexpr int kDrives = 20000;
  for (int readings : {1, 10, 100}) {
    double sum = 0.0;
    for (std::uint64_t seed = 0; seed < kDrives; ++seed) {
      WheelEncoder wheel = encoder({1e-4, 0.005, 32, 0}, seed);
      for (int i = 1; i <= readings; ++i) wheel.read(-2.0 * i / readings);
      sum += std::pow(wheel.measuredTravel() + 2.0, 2);
    }
    EXPECT_NEAR(sum / kDrives / (0.005 * 0.005 * 2.0), 1.0, 0.04) << readings << " readings, seeds from 0";
  }
}

// The error of a reading is a draw times sqrt|S|: at most half_width sqrt|S|, for a step back too.
TEST(WheelEncoder, errorsOfAReadingComeFromTheDistribution) {
  constexpr int kReadings = 100000;
  constexpr double kHalfWidth = 0.005;
  constexpr double kStep = 0.04;
  WheelEncoder wheel = encoder({1e-4, Distribution::uniform(kHalfWidth), 32, 0});
  double before = 0.0;
  double largest = 0.0;
  double sum = 0.0;
  for (int i = 1; i <= kReadings; ++i) {
    wheel.read(i % 2 * kStep);
    const double error = wheel.measuredTravel() - i % 2 * kStep;
    largest = std::max(largest, std::abs(error - before));
    sum += std::pow(error - before, 2);
    before = error;
  }
  EXPECT_LE(largest, kHalfWidth * std::sqrt(kStep) * (1.0 + 1e-9)) << "differences of sums, rounded";
  EXPECT_GT(largest, 0.999 * kHalfWidth * std::sqrt(kStep));
  // Five standard errors of the variance of a uniform distribution: 5 sqrt(0.8 / 1e5).
  EXPECT_NEAR(sum / kReadings / (kHalfWidth * kHalfWidth / 3.0 * kStep), 1.0, 0.0142);
}

}  // namespace
}  // namespace bs_car_odometry::simulation
