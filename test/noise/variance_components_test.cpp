// The likelihood against a dense one, and against the closed forms of the analysis of variance.

#include "../../src/tools/variance_components.hpp"

#include "../../src/tools/variance_fit.hpp"
#include "support/seeded_generator.hpp"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <cmath>
#include <limits>
#include <vector>

namespace bs_car_odometry::tools::testing {
namespace {

using test_support::SeededGenerator;

constexpr Eigen::Index kRows = 4;
constexpr Eigen::Index kGains = 2;

Eigen::MatrixXd randomMatrix(Eigen::Index rows, Eigen::Index columns, SeededGenerator& random) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(1.0); });
}

Eigen::MatrixXd randomCovariance(Eigen::Index n, SeededGenerator& random) {
  const Eigen::MatrixXd A = randomMatrix(n, n, random);
  return A * A.transpose() + Eigen::MatrixXd::Identity(n, n);
}

LinearDrive randomDrive(SeededGenerator& random) {
  return {randomMatrix(kRows, 1, random),
          randomMatrix(kRows, kGains, random),
          randomCovariance(kRows, random),
          {randomCovariance(kRows, random)}};
}

/// Two recordings, of two drives and of one, on the same wheels; written out as one Gaussian vector.
TEST(VarianceComponents, likelihoodIsThatOfTheJointDensity) {
  SeededGenerator random(11);
  const std::vector<LinearDrive> drives{randomDrive(random), randomDrive(random), randomDrive(random)};
  const GainPrior prior{Eigen::Vector2d(0.3, -0.2), Eigen::Vector2d(0.5, 2.0)};
  // The second gain varies between recordings.
  const VarianceComponents model({{&drives[0], 0, 7}, {&drives[1], 0, 3}, {&drives[2], 0, 7}}, {prior},
                                 {-1, 0});
  const Eigen::Vector2d variances(0.8, 1.7);

  const Eigen::Index n = 3 * kRows;
  Eigen::VectorXd y(n);
  Eigen::MatrixXd X(n, kGains);
  Eigen::MatrixXd V = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const LinearDrive& drive = drives[static_cast<std::size_t>(i)];
    y.segment(i * kRows, kRows) = drive.error;
    X.middleRows(i * kRows, kRows) = drive.sensitivity;
    V.block(i * kRows, i * kRows, kRows, kRows) = drive.known + 0.8 * drive.components[0];
  }
  Eigen::MatrixXd draws = Eigen::MatrixXd::Zero(n, 2);  // the second gain in each recording
  draws.col(0).head(kRows) = X.col(1).head(kRows);
  draws.col(0).tail(kRows) = X.col(1).tail(kRows);
  draws.col(1).segment(kRows, kRows) = X.col(1).segment(kRows, kRows);
  V += 1.7 * draws * draws.transpose();
  const Eigen::MatrixXd joint = V + X * prior.variance.asDiagonal() * X.transpose();
  const Eigen::VectorXd error = y - X * prior.mean;
  const Eigen::LLT<Eigen::MatrixXd> factor(joint);
  const double log_determinant = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  const double expected = -0.5 * (static_cast<double>(n) * std::log(2.0 * M_PI) + log_determinant +
                                  error.dot(factor.solve(error)));
  EXPECT_NEAR(model.logLikelihood(variances), expected, 1e-10 * std::abs(expected));

  const Eigen::MatrixXd weight = V.inverse();
  const Eigen::Matrix2d information =
      X.transpose() * weight * X + Eigen::Matrix2d(prior.variance.cwiseInverse().asDiagonal());
  const Eigen::Vector2d mean =
      information.inverse() *
      (X.transpose() * weight * y + prior.variance.cwiseInverse().cwiseProduct(prior.mean));
  const GainEstimate gains = model.gains(variances).at(0);
  EXPECT_LT((gains.covariance - information.inverse()).norm(), 1e-10);
  EXPECT_LT((gains.mean - mean).norm(), 1e-10);
}

TEST(VarianceComponents, wheelsOfTheirOwnAreIndependent) {
  SeededGenerator random(12);
  const LinearDrive a = randomDrive(random);
  const LinearDrive b = randomDrive(random);
  const GainPrior prior{Eigen::Vector2d::Zero(), Eigen::Vector2d::Ones()};
  const Eigen::VectorXd variances = Eigen::VectorXd::Constant(1, 0.5);
  const double together =
      VarianceComponents({{&a, 0, 0}, {&b, 1, 1}}, {prior, prior}, {-1, -1}).logLikelihood(variances);
  const double apart = VarianceComponents({{&a, 0, 0}}, {prior}, {-1, -1}).logLikelihood(variances) +
                       VarianceComponents({{&b, 0, 0}}, {prior}, {-1, -1}).logLikelihood(variances);
  EXPECT_NEAR(together, apart, 1e-10);
}

TEST(VarianceComponents, noCovarianceIsNoLikelihood) {
  SeededGenerator random(13);
  LinearDrive drive = randomDrive(random);
  drive.known.setZero();
  const GainPrior prior{Eigen::Vector2d::Zero(), Eigen::Vector2d::Ones()};
  const VarianceComponents model({{&drive, 0, 0}}, {prior}, {-1, -1});
  EXPECT_EQ(model.logLikelihood(Eigen::VectorXd::Zero(1)), -std::numeric_limits<double>::infinity());
}

/// Balanced one-way layout: `groups` recordings of one drive each with `members` rows, one gain that all rows
/// see with factor 1. Restricted maximum likelihood is then the analysis of variance:
/// theta = MSW, systematic = (MSB - MSW)/members.
class OneWayLayout {
 public:
  OneWayLayout(double spread, SeededGenerator& random) {
    for (std::size_t g = 0; g < kGroups; ++g) {
      LinearDrive drive{randomMatrix(kMembers, 1, random),
                        Eigen::MatrixXd::Ones(kMembers, 1),
                        Eigen::MatrixXd::Zero(kMembers, kMembers),
                        {Eigen::MatrixXd::Identity(kMembers, kMembers)}};
      drive.error.array() += random.normal(spread);
      drives_.push_back(drive);
    }
  }

  VarianceFit fit() const {
    std::vector<GroupedDrive> grouped;
    for (std::size_t g = 0; g < kGroups; ++g) grouped.push_back({&drives_[g], 0, g});
    const GainPrior flat{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Constant(1, 1e8)};
    const VarianceComponents model(grouped, {flat}, {0});
    return fitVariances([&](const Eigen::VectorXd& v) { return model.logLikelihood(v); },
                        Eigen::Vector2d(0.1, 0.1));
  }

  double within() const {
    double squares = 0.0;
    for (const LinearDrive& drive : drives_)
      squares += (drive.error.array() - drive.error.mean()).matrix().squaredNorm();
    return squares / static_cast<double>(kGroups * (kMembers - 1));
  }

  double between() const {
    double mean = 0.0;
    for (const LinearDrive& drive : drives_) mean += drive.error.mean() / kGroups;
    double squares = 0.0;
    for (const LinearDrive& drive : drives_) squares += std::pow(drive.error.mean() - mean, 2);
    return kMembers * squares / (kGroups - 1);
  }

  static constexpr int kGroups = 12;
  static constexpr int kMembers = 6;

 private:
  std::vector<LinearDrive> drives_;
};

TEST(VarianceComponents, isTheAnalysisOfVarianceInABalancedLayout) {
  SeededGenerator random(14);
  const OneWayLayout layout(2.0, random);
  const VarianceFit fit = layout.fit();
  ASSERT_GT(layout.between(), layout.within());
  // 1e-3: where the search stops, see VarianceFit.findsTheVarianceOfNormalDraws.
  EXPECT_NEAR(fit.variances[0], layout.within(), 1e-3);
  EXPECT_NEAR(fit.variances[1], (layout.between() - layout.within()) / OneWayLayout::kMembers, 2e-3);
}

/// Without a spread, half of all layouts have MSB < MSW: the spread found is then 0, and the other variance
/// that of all rows about their mean, with its lost degree of freedom.
TEST(VarianceComponents, aSpreadThatIsNotThereIsZero) {
  SeededGenerator random(15);
  int zeros = 0;
  for (int i = 0; i < 20; ++i) {
    const OneWayLayout layout(0.0, random);
    const VarianceFit fit = layout.fit();
    if (layout.between() > layout.within()) {
      // 1.1: a spread so small that the likelihood hardly tells it from none counts as none.
      if (layout.between() > 1.1 * layout.within()) {
        EXPECT_GT(fit.variances[1], 0.0);
      }
      continue;
    }
    ++zeros;
    constexpr double kRowsOfAll = OneWayLayout::kGroups * OneWayLayout::kMembers;
    const double squares = layout.within() * (kRowsOfAll - OneWayLayout::kGroups) +
                           layout.between() * (OneWayLayout::kGroups - 1);
    EXPECT_EQ(fit.variances[1], 0.0);
    EXPECT_NEAR(fit.variances[0], squares / (kRowsOfAll - 1), 1e-3);
  }
  EXPECT_GT(zeros, 3) << "the test should see some";
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
