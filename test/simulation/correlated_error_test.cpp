#include "bs_car_odometry/simulation/correlated_error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace bs_car_odometry::simulation {
namespace {

constexpr double kStd = 0.003;
constexpr double kLength = 0.1;

/// Variance of the mean error over `travel`, taken in `parts` readings, over 20000 processes: relative
/// standard error 1 %.
double varianceOfMean(double travel, int parts) {
  constexpr int kProcesses = 20000;
  double sum = 0.0;
  for (std::uint64_t seed = 0; seed < kProcesses; ++seed) {
    CorrelatedError error(kStd, kLength, Random(seed, 5));
    double mean = 0.0;
    for (int i = 0; i < parts; ++i) mean += error.advance(travel / parts) / parts;
    sum += mean * mean;
  }
  return sum / kProcesses;
}

TEST(CorrelatedError, shortTravelKeepsTheFullVariance) {
  EXPECT_NEAR(varianceOfMean(0.001, 1) / (kStd * kStd), 1.0, 0.04);
}

// Int over the triangular autocorrelation: std^2 (1 - d/(3l)) for d <= l, std^2 (l/d)(1 - l/(3d)) beyond.
TEST(CorrelatedError, meanOverTravelHasTheClosedFormVariance) {
  EXPECT_NEAR(varianceOfMean(0.05, 1) / (kStd * kStd * (1.0 - 0.5 / 3.0)), 1.0, 0.04);
  EXPECT_NEAR(varianceOfMean(0.1, 1) / (kStd * kStd * 2.0 / 3.0), 1.0, 0.04);
  EXPECT_NEAR(varianceOfMean(2.0, 1) / (kStd * kStd * 0.05 * (1.0 - 0.05 / 3.0)), 1.0, 0.04);
}

TEST(CorrelatedError, meanOverADriveDoesNotDependOnTheNumberOfReadings) {
  const double expected = kStd * kStd * 0.05 * (1.0 - 0.05 / 3.0);
  for (int parts : {1, 7, 100, 1000}) EXPECT_NEAR(varianceOfMean(2.0, parts) / expected, 1.0, 0.04) << parts;
}

TEST(CorrelatedError, readingsShareOneProcessWhateverTheirSpacing) {
  CorrelatedError whole(kStd, kLength, Random(3, 0));
  CorrelatedError parts(kStd, kLength, Random(3, 0));
  double mean = 0.0;
  for (int i = 0; i < 64; ++i) mean += parts.advance(1.0 / 64.0) / 64.0;
  EXPECT_NEAR(whole.advance(1.0), mean, 1e-15);
  EXPECT_EQ(whole.value(), parts.value());
}

TEST(CorrelatedError, staysAsItIsWithoutTravel) {
  CorrelatedError error(kStd, kLength, Random(3, 0));
  const double value = error.value();
  EXPECT_NE(value, 0.0);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(error.advance(0.0), value);
}

TEST(CorrelatedError, isZeroWithoutNoiseWhateverTheLength) {
  CorrelatedError error(0.0, 0.0, Random(3, 0));
  EXPECT_EQ(error.advance(5.0), 0.0);
}

TEST(CorrelatedError, takesItsValuesFromTheDistribution) {
  constexpr double kHalfWidth = 0.004;
  CorrelatedError error(Distribution::uniform(kHalfWidth), kLength, Random(3, 0));
  double largest = 0.0;
  double sum = 0.0;
  constexpr int kValues = 100000;
  for (int i = 0; i < kValues; ++i) {
    error.advance(kLength);
    largest = std::max(largest, std::abs(error.value()));
    sum += error.value() * error.value();
  }
  EXPECT_LE(largest, kHalfWidth);
  EXPECT_GT(largest, 0.999 * kHalfWidth);
  // Five standard errors of the variance: 5 sqrt(0.8 / 1e5).
  EXPECT_NEAR(sum / kValues / (kHalfWidth * kHalfWidth / 3.0), 1.0, 0.0142);
}

TEST(CorrelatedError, refusesALengthThatIsNotPositive) {
  EXPECT_THROW(CorrelatedError(kStd, 0.0, Random(3, 0)), std::invalid_argument);
}

}  // namespace
}  // namespace bs_car_odometry::simulation
