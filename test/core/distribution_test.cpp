// Moments of the distributions against closed forms, and what is refused.

#include "bs_car_odometry/core/distribution.hpp"

#include "support/matchers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace bs_car_odometry {
namespace {

using test_support::relativelyNear;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The quadrature's panels of 1/8 leave about 1e-15 of each integral; a ratio of sums of up to 1200 terms
/// rounds to some 1e-14.
constexpr double kQuadrature = 1e-13;

TEST(Distribution, aNumberIsTheStandardDeviationOfAGaussian) {
  const Distribution distribution = 0.25;
  EXPECT_EQ(distribution.shape(), Distribution::Shape::kGaussian);
  EXPECT_EQ(distribution.scale(), 0.25);
  EXPECT_EQ(distribution.std(), 0.25);
  EXPECT_EQ(distribution.variance(), 0.0625);
  EXPECT_EQ(distribution.kurtosis(), 3.0);
  EXPECT_EQ(distribution.truncation(), kInfinity);
  EXPECT_EQ(Distribution().std(), 0.0);
  EXPECT_EQ(Distribution::gaussian(0.25).std(), 0.25);
  EXPECT_EQ(Distribution::gaussian(0.25).kurtosis(), 3.0);
}

TEST(Distribution, uniformAndTriangularHaveTheMomentsOfTheirIntegrals) {
  const Distribution uniform = Distribution::uniform(0.3);
  EXPECT_EQ(uniform.shape(), Distribution::Shape::kUniform);
  EXPECT_EQ(uniform.scale(), 0.3);
  EXPECT_DOUBLE_EQ(uniform.variance(), 0.03);     // h^2 / 3
  EXPECT_DOUBLE_EQ(uniform.kurtosis(), 9.0 / 5);  // (h^4 / 5) / (h^2 / 3)^2
  const Distribution triangular = Distribution::triangular(0.3);
  EXPECT_EQ(triangular.shape(), Distribution::Shape::kTriangular);
  EXPECT_DOUBLE_EQ(triangular.variance(), 0.015);      // h^2 / 6
  EXPECT_DOUBLE_EQ(triangular.kurtosis(), 36.0 / 15);  // (h^4 / 15) / (h^2 / 6)^2
}

TEST(Distribution, studentTHasItsTextbookMoments) {
  const Distribution five = Distribution::studentT(0.3, 5.0);
  EXPECT_EQ(five.shape(), Distribution::Shape::kStudentT);
  EXPECT_EQ(five.degreesOfFreedom(), 5.0);
  EXPECT_DOUBLE_EQ(five.variance(), 0.09 * 5.0 / 3.0);
  EXPECT_DOUBLE_EQ(five.kurtosis(), 9.0);
  EXPECT_DOUBLE_EQ(Distribution::studentT(1.0, 2.5).variance(), 5.0);
  EXPECT_EQ(Distribution::studentT(1.0, 4.0).kurtosis(), kInfinity);
}

// With a = T / std, phi the density and Z the mass within: Var / std^2 = 1 - 2 a phi / Z, the fourth moment
// 3 - 2 (a^3 + 3 a) phi / Z, by parts.
TEST(Distribution, aTruncatedGaussianHasTheMomentsOfTheClosedForm) {
  for (const double a : {0.5, 1.0, 2.0, 3.0, 6.0}) {
    SCOPED_TRACE(a);
    const double density = std::exp(-0.5 * a * a) / std::sqrt(2.0 * std::acos(-1.0));
    const double mass = std::erf(a / std::sqrt(2.0));
    const double second = 1.0 - 2.0 * a * density / mass;
    const double fourth = 3.0 - 2.0 * (a * a * a + 3.0 * a) * density / mass;
    const Distribution truncated = Distribution::gaussian(0.2, 0.2 * a);
    EXPECT_EQ(truncated.scale(), 0.2);
    EXPECT_EQ(truncated.truncation(), 0.2 * a);
    // The closed forms lose up to three digits at a = 0.5, where their terms cancel to 0.08 and 0.01.
    EXPECT_TRUE(relativelyNear(truncated.variance(), 0.04 * second, 1e-12));
    EXPECT_TRUE(relativelyNear(truncated.kurtosis(), fourth / (second * second), 1e-12));
  }
}

// One degree of freedom is Cauchy's density 1 / (1 + x^2): Int_0^T of 1, x^2, x^4 times it is
// atan T, T - atan T, T^3/3 - T + atan T.
TEST(Distribution, aTruncatedCauchyHasTheMomentsOfTheClosedForm) {
  for (const double T : {2.0, 30.0, 1e6, 1e12}) {
    SCOPED_TRACE(T);
    const double mass = std::atan(T);
    const double second = (T - mass) / mass;
    const double fourth = (T * T * T / 3.0 - T + mass) / mass;
    const Distribution truncated = Distribution::studentT(0.2, 1.0, 0.2 * T);
    EXPECT_TRUE(relativelyNear(truncated.variance(), 0.04 * second, kQuadrature));
    EXPECT_TRUE(relativelyNear(truncated.kurtosis(), fourth / (second * second), kQuadrature));
  }
}

// Three degrees of freedom: density (1 + y^2)^-2 with y = x / sqrt(3).
TEST(Distribution, aTruncatedStudentTHasTheMomentsOfTheClosedForm) {
  for (const double T : {1.0, 4.0, 100.0}) {
    SCOPED_TRACE(T);
    const double y = T / std::sqrt(3.0);
    const double rest = y / (1.0 + y * y);
    const double mass = 0.5 * (std::atan(y) + rest);
    const double second = 3.0 * 0.5 * (std::atan(y) - rest) / mass;
    const double fourth = 9.0 * (y + 0.5 * rest - 1.5 * std::atan(y)) / mass;
    const Distribution truncated = Distribution::studentT(1.0, 3.0, T);
    // At T = 1 the terms of the closed form of the fourth moment cancel to 5 % of their size.
    EXPECT_TRUE(relativelyNear(truncated.variance(), second, 1e-12));
    EXPECT_TRUE(relativelyNear(truncated.kurtosis(), fourth / (second * second), 1e-12));
  }
}

TEST(Distribution, aFarTruncationChangesNothing) {
  const Distribution gaussian = Distribution::gaussian(0.2, 0.2e6);
  EXPECT_TRUE(relativelyNear(gaussian.std(), 0.2, kQuadrature));
  EXPECT_TRUE(relativelyNear(gaussian.kurtosis(), 3.0, kQuadrature));
  const Distribution student = Distribution::studentT(0.2, 12.0, 0.2e6);
  const Distribution whole = Distribution::studentT(0.2, 12.0);
  EXPECT_TRUE(relativelyNear(student.std(), whole.std(), kQuadrature));
  EXPECT_TRUE(relativelyNear(student.kurtosis(), whole.kurtosis(), kQuadrature));
}

// Many degrees of freedom are a Gaussian: the densities differ by x^4 / (4 dof), so the moments by about
// 1e-6.
TEST(Distribution, aStudentTOfManyDegreesOfFreedomIsAGaussian) {
  const Distribution student = Distribution::studentT(0.2, 1e6, 0.3);
  const Distribution gaussian = Distribution::gaussian(0.2, 0.3);
  EXPECT_TRUE(relativelyNear(student.std(), gaussian.std(), 2e-6));
  EXPECT_TRUE(relativelyNear(student.kurtosis(), gaussian.kurtosis(), 2e-6));
}

TEST(Distribution, ofNoErrorIsZeroWhateverItsShape) {
  for (const Distribution& none : {Distribution::gaussian(0.0, 0.1), Distribution::uniform(0.0),
                                   Distribution::triangular(0.0), Distribution::studentT(0.0, 1.0, 0.1)}) {
    EXPECT_EQ(none.std(), 0.0);
    EXPECT_TRUE(std::isfinite(none.kurtosis()));
  }
}

TEST(Distribution, refusesWhatIsOutsideItsLimits) {
  const double nan = std::nan("");
  for (const double bad : {-0.1, nan, kInfinity}) {
    EXPECT_THROW(Distribution::gaussian(bad), std::invalid_argument) << bad;
    EXPECT_THROW(Distribution::uniform(bad), std::invalid_argument) << bad;
    EXPECT_THROW(Distribution::triangular(bad), std::invalid_argument) << bad;
    EXPECT_THROW(Distribution::studentT(bad, 5.0), std::invalid_argument) << bad;
  }
  for (const double bad : {0.04, 0.0, -1.0, nan, 1e12})
    EXPECT_THROW(Distribution::gaussian(0.1, bad), std::invalid_argument) << bad;
  for (const double bad : {2.0, 0.0, -1.0, nan, kInfinity})
    EXPECT_THROW(Distribution::studentT(0.1, bad), std::invalid_argument) << bad;
  EXPECT_THROW(Distribution::studentT(0.1, 0.9, 1.0), std::invalid_argument);
  EXPECT_NO_THROW(Distribution::studentT(0.1, 1.0, 0.05));
}

}  // namespace
}  // namespace bs_car_odometry
