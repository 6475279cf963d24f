// Independent variances in the place of a full covariance.

#include "../../src/tools/independent_spread.hpp"

#include <gmock/gmock.h>

namespace bs_car_odometry::tools::testing {
namespace {

TEST(IndependentSpread, keepsVariancesThatAreIndependent) {
  const Eigen::Matrix3d J = (Eigen::Matrix3d() << 1, 2, 0, -1, 1, 3, 0, 1, 1).finished();
  const Eigen::Vector3d variances(0.5, 2.0, 0.1);
  const GainEffect effect{J, variances.asDiagonal()};
  EXPECT_TRUE(independentVariances({effect}, {0, 1, 2}).isApprox(variances, 1e-9));
}

TEST(IndependentSpread, sharesAVarianceAmongAxles) {
  const GainEffect effect{Eigen::RowVector2d(1.0, 2.0), Eigen::Vector2d(5.0, 1.0).asDiagonal()};
  // 1 * 5 + 4 * 1 = 9 at the end, of which each unit of a common variance makes 1 + 4.
  EXPECT_NEAR(independentVariances({effect}, {0, 0})[0], 9.0 / 5.0, 1e-12);
}

/// Two gains of which only the sum matters and is known: the diagonal says 100 each, the end knows better.
TEST(IndependentSpread, doesNotInflateWhatIsCorrelated) {
  const Eigen::Matrix2d covariance = (Eigen::Matrix2d() << 100.0, -99.5, -99.5, 100.0).finished();
  const GainEffect effect{Eigen::RowVector2d(1.0, 1.0), covariance};
  EXPECT_NEAR(independentVariances({effect}, {0, 0})[0], 0.5, 1e-9);
}

TEST(IndependentSpread, isNowhereNegative) {
  // x and y of an end, whose errors the gains would have to make smaller: the second gain can only add.
  const Eigen::Matrix2d J = (Eigen::Matrix2d() << 1.0, 1.0, 0.0, 1.0).finished();
  const GainEffect effect{J, (Eigen::Matrix2d() << 4.0, -3.0, -3.0, 3.0).finished()};
  const Eigen::VectorXd variances = independentVariances({effect}, {0, 1});
  EXPECT_GE(variances.minCoeff(), 0.0);
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
