// fitVariances(): maxima that are known.

#include "../../src/tools/variance_fit.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace bs_car_odometry::tools::testing {
namespace {

/// Log-likelihood of the variance, from n normal draws whose squares add up to n times `mean_square`.
double ofDraws(double n, double mean_square, double variance) {
  return -0.5 * n * (std::log(variance) + mean_square / variance);
}

TEST(VarianceFit, findsTheVarianceOfNormalDraws) {
  const auto likelihood = [](const Eigen::VectorXd& v) { return ofDraws(50.0, 4.0, v[0]); };
  for (const double start : {1e-4, 4.0, 1e4}) {
    const VarianceFit fit = fitVariances(likelihood, Eigen::VectorXd::Constant(1, start));
    // The search stops where another step would gain less than 1e-7, which is 1e-4 of the variance here.
    EXPECT_NEAR(fit.variances[0], 4.0, 1e-3) << "from " << start;
    // Of the root: sigma/sqrt(2 n), to the accuracy of the differences.
    EXPECT_NEAR(fit.std_of_roots[0], 2.0 / std::sqrt(100.0), 1e-3);
    EXPECT_NEAR(fit.log_likelihood, ofDraws(50.0, 4.0, 4.0), 1e-6);
  }
}

/// A known variance of 1 and one that is sought, when the draws scatter by less than the known one.
TEST(VarianceFit, findsThatThereIsNothing) {
  const auto likelihood = [](const Eigen::VectorXd& v) { return ofDraws(50.0, 0.9, 1.0 + v[0]); };
  const VarianceFit fit = fitVariances(likelihood, Eigen::VectorXd::Constant(1, 1.0));
  EXPECT_EQ(fit.variances[0], 0.0);
  EXPECT_EQ(fit.std_of_roots[0], 0.0);
  EXPECT_EQ(fit.log_likelihood, ofDraws(50.0, 0.9, 1.0));
}

/// The second group alone says what the sum of both is; the first has more than enough.
TEST(VarianceFit, seeksTheOthersAgainWhenOneIsNothing) {
  const auto likelihood = [](const Eigen::VectorXd& v) {
    return ofDraws(40.0, 3.0, v[0]) + ofDraws(40.0, 2.0, v[0] + v[1]);
  };
  const VarianceFit fit = fitVariances(likelihood, Eigen::Vector2d(1.0, 1.0));
  EXPECT_EQ(fit.variances[1], 0.0);
  EXPECT_NEAR(fit.variances[0], 2.5, 1e-3);  // both groups together; 1e-3 as above
}

TEST(VarianceFit, saysWhenThereIsNoLikelihoodAtTheStart) {
  const auto nowhere = [](const Eigen::VectorXd&) { return -std::numeric_limits<double>::infinity(); };
  EXPECT_THROW(fitVariances(nowhere, Eigen::VectorXd::Constant(1, 1.0)), std::runtime_error);
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
