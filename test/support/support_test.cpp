#include "support/figure.hpp"
#include "support/matchers.hpp"
#include "support/numerical_derivative.hpp"
#include "support/seeded_generator.hpp"

#include <cmath>
#include <utility>

namespace bs_car_odometry::test_support {
namespace {

TEST(RelativelyNear, MatchesWithinTheTolerance) { EXPECT_TRUE(relativelyNear(1000.0 + 1e-7, 1000.0, 1e-9)); }
TEST(RelativelyNear, DoesNotMatchBeyond) { EXPECT_FALSE(relativelyNear(1e-3 + 1e-11, 1e-3, 1e-9)); }
TEST(RelativelyNear, DoesNotMatchNan) { EXPECT_FALSE(relativelyNear(std::nan(""), 1.0, 1e-9)); }

TEST(MatrixNear, MatchesWithinTheTolerance) {
  EXPECT_TRUE(matrixNear(Eigen::Vector2d(1.0, 2.0 + 1e-10), Eigen::Vector2d(1.0, 2.0), 1e-9));
}
TEST(MatrixNear, DoesNotMatchOneWrongEntry) {
  EXPECT_FALSE(matrixNear(Eigen::Vector2d(1.0, 2.0 + 1e-8), Eigen::Vector2d(1.0, 2.0), 1e-9));
}
TEST(MatrixNear, DoesNotMatchNan) {
  EXPECT_FALSE(matrixNear(Eigen::Vector2d(1.0, std::nan("")), Eigen::Vector2d(1.0, 2.0), 1e-9));
}

TEST(MatrixRelativelyNear, TakesZeroAgainstTheLargestEntry) {
  EXPECT_TRUE(matrixRelativelyNear(Eigen::Vector2d(1.0, 1e-10), Eigen::Vector2d(1.0, 0.0), 1e-9));
}
TEST(MatrixRelativelyNear, DoesNotMatchAWrongSmallEntry) {
  EXPECT_FALSE(matrixRelativelyNear(Eigen::Vector2d(1.0, 2e-10), Eigen::Vector2d(1.0, 1e-10), 1e-9));
}

TEST(IsCovariance, MatchesASingularOne) {
  EXPECT_TRUE(isCovariance(Eigen::Vector3d(1.0, 0.0, 2.0).asDiagonal()));
}
TEST(IsCovariance, DoesNotMatchANegativeEigenvalue) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix(0, 1) = matrix(1, 0) = 1.1;
  EXPECT_FALSE(isCovariance(matrix));
}
TEST(IsCovariance, DoesNotMatchAnAsymmetricOne) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix(0, 1) = 1e-15;
  EXPECT_FALSE(isCovariance(matrix));
}

TEST(NumericalDerivative, OfAKnownFunction) {
  const auto f = [](const Eigen::Vector2d& x) { return Eigen::Vector2d(std::sin(x(0)) * x(1), x(1) * x(1)); };
  Eigen::Matrix2d expected;
  expected << std::cos(0.3) * 2.0, std::sin(0.3), 0.0, 4.0;
  const Eigen::Matrix2d J = numericalDerivative<2, 2>(f, Eigen::Vector2d(0.3, 2.0));
  EXPECT_TRUE(matrixNear(J, expected, 1e-11));
  EXPECT_FALSE(matrixNear(J, expected.transpose(), 1e-11));
}

TEST(SeededGenerator, RepeatsItselfWithTheVarianceAskedFor) {
  SeededGenerator first(7);
  SeededGenerator again(7);
  SeededGenerator other(8);
  EXPECT_EQ(first.normal(4.0), again.normal(4.0));
  EXPECT_NE(first.normal(4.0), other.normal(4.0));
  constexpr int kDraws = 10000;
  double sum_of_squares = 0.0;
  for (int i = 0; i < kDraws; ++i) sum_of_squares += std::pow(first.normal(4.0), 2);
  // The mean of n squares has the relative standard deviation sqrt(2/n) = 1.4 %; four of them.
  EXPECT_NEAR(sum_of_squares / kDraws, 4.0, 4.0 * 4.0 * std::sqrt(2.0 / kDraws));
}

TEST(RoundedUp, IsOneTwoOrFiveAtLeastAsLarge) {
  const std::pair<double, double> expected[] = {{0.0, 0.0},     {-1.0, 0.0},    {1.0, 1.0},  {1.1, 2.0},
                                                {0.004, 0.005}, {0.06, 0.1},    {9.0, 10.0}, {0.2, 0.2},
                                                {3e-9, 5e-9},   {501.0, 1000.0}};
  for (const auto& [value, rounded] : expected) EXPECT_DOUBLE_EQ(roundedUp(value), rounded) << value;
  EXPECT_EQ(roundedUp(std::nan("")), 0.0);
}

TEST(RecordedFigure, IsAPropertyOfTheTest) {
  recordFigure("%d of %s", 3, "four");
  const ::testing::TestResult& result = *::testing::UnitTest::GetInstance()->current_test_info()->result();
  ASSERT_EQ(result.test_property_count(), 1);
  EXPECT_STREQ(result.GetTestProperty(0).key(), "figure");
  EXPECT_STREQ(result.GetTestProperty(0).value(), "3 of four");
}

}  // namespace
}  // namespace bs_car_odometry::test_support
