// The bound of the calibration against reference values, and against an information matrix of everything at
// once (docs/calibration.md, 5).
#include "bs_car_odometry/calibration/cramer_rao_bound.hpp"

#include "reference_run.hpp"
#include "support/matchers.hpp"

#include <Eigen/Dense>

#include <cmath>
#include <iostream>

namespace bs_car_odometry::calibration {
namespace {

using reference::Step;
using test_support::relativelyNear;
using Gains = Eigen::Vector3d;

/// Follows a run; the gains are the parameters, with the steering offset and the laser's time offset where
/// five are asked for.
class Run {
 public:
  explicit Run(const Eigen::VectorXd& prior) : bound_(prior), count_(prior.size()) { fix(Gains::Zero()); }

  void take(const Step& step) {
    const reference::Linearised at = reference::linearise(step);
    Eigen::Matrix<double, 3, 5> J;
    J << at.J, at.G.col(2), Eigen::Vector3d::Zero();
    bound_.predict(at.F, J.leftCols(count_), at.Q());
    if (step.laser) fix(step.velocity);
  }

  Eigen::VectorXd deviations() const { return bound_.deviations(); }

 private:
  void fix(const Eigen::Vector3d& velocity) {
    Eigen::Matrix<double, 3, 5> H = Eigen::Matrix<double, 3, 5>::Zero();
    H.col(4) = -velocity;
    bound_.update(Eigen::Matrix3d::Identity(), H.leftCols(count_), reference::laserCovariance());
  }

  CramerRaoBound bound_;
  Eigen::Index count_;
};

Eigen::VectorXd boundOf(const std::vector<Step>& steps, const Eigen::VectorXd& prior) {
  Run run(prior);
  for (const Step& step : steps) run.take(step);
  return run.deviations();
}

/// The beginning of a run [s].
std::vector<Step> until(double time, const std::vector<Step>& steps) {
  return {steps.begin(), steps.begin() + std::lround(time / reference::kPeriod)};
}

const std::vector<Step>& fifteenSeconds() {
  static const std::vector<Step> steps = reference::drive(reference::fifteenSeconds(), 15.0);
  return steps;
}

/// To the digits that the reference values are given with.
void expectNear(const Eigen::VectorXd& values, const Eigen::VectorXd& expected, double tolerance) {
  ASSERT_EQ(values.size(), expected.size());
  EXPECT_TRUE(test_support::matrixNear(values, expected, tolerance));
}

TEST(CramerRaoBound, theReferenceRunIsTheOneThatTheValuesBelongTo) {
  double right = 0.0;
  double left = 0.0;
  for (const Step& step : fifteenSeconds()) {
    right += step.right;
    left += step.left;
  }
  EXPECT_NEAR(fifteenSeconds().back().distance, 19.043, 5e-4);
  EXPECT_NEAR(right, 20.053184258, 1e-9);
  EXPECT_NEAR(left, 18.033382088, 1e-9);
  expectNear(fifteenSeconds().back().after, Gains(7.938528977, 11.776554742, 1.681686932), 1e-9);
}

TEST(CramerRaoBound, ofTheReferenceRunWithAndWithoutPrior) {
  expectNear(boundOf(fifteenSeconds(), Gains::Constant(kDiffuse)), Gains(0.00128997, 0.00134294, 0.00865867),
             5.1e-9);
  expectNear(boundOf(fifteenSeconds(), Gains::Constant(0.02)), Gains(0.00127604, 0.00132635, 0.00794250),
             5.1e-9);
}

/// A diffuse beginning is one whose width does not matter any more. The shift of the bound is about its own
/// square over the prior's: 0.4e-8 of it for a deviation of 100.
TEST(CramerRaoBound, doesNotDependOnHowDiffuseTheBeginningIs) {
  const Eigen::VectorXd diffuse = boundOf(fifteenSeconds(), Gains::Constant(kDiffuse));
  for (const double deviation : {1e2, 1e3, 1e4})
    EXPECT_TRUE(test_support::matrixRelativelyNear(boundOf(fifteenSeconds(), Gains::Constant(deviation)),
                                                   diffuse, 1e-8))
        << deviation;
}

/// How the laser's velocity follows from the run is left open by the values: speed and turning rate at the
/// instant or by differences of the poses move the time offset's bound by 0.1 %, the others by 1e-8.
TEST(CramerRaoBound, withSteeringOffsetAndTimeOffset) {
  const Eigen::VectorXd bound = boundOf(fifteenSeconds(), Eigen::VectorXd::Constant(5, kDiffuse));
  expectNear(bound.head(3), Gains(0.00129310, 0.00134345, 0.00867607), 1.5e-8);
  EXPECT_NEAR(bound(3), 0.00061211, 0.51e-8);
  EXPECT_TRUE(relativelyNear(bound(4), 0.00458276, 1e-3));
}

/// After 4, 7 and 8 s; given with four decimals.
TEST(CramerRaoBound, fallsAlongTheReferenceRun) {
  const auto after = [](double time) {
    return boundOf(until(time, fifteenSeconds()), Gains::Constant(0.02));
  };
  expectNear(after(4.0), Gains(0.0032, 0.0032, 0.0199), 0.51e-4);  // 4.7 m
  expectNear(after(7.0), Gains(0.0021, 0.0022, 0.0118), 0.51e-4);  // 8.8 m
  expectNear(after(8.0), Gains(0.0020, 0.0021, 0.0098), 0.51e-4);  // 10.1 m
}

/// Given with two digits.
TEST(CramerRaoBound, ofTheSlalomEight) {
  const std::vector<Step> steps = reference::drive(reference::slalomEight(), 100.0);
  const auto after = [&](double time) { return boundOf(until(time, steps), Gains::Constant(kDiffuse)); };
  expectNear(after(20.0), Gains(0.0013, 0.0013, 0.0030), 0.51e-4);
  const Eigen::VectorXd at_60 = after(60.0);
  expectNear(at_60.head(2), Eigen::Vector2d(0.00074, 0.00072), 0.51e-5);
  EXPECT_NEAR(at_60(2), 0.0017, 0.51e-4);
  const Eigen::VectorXd at_100 = after(100.0);
  expectNear(at_100.head(2), Eigen::Vector2d(0.00057, 0.00055), 0.51e-5);
  EXPECT_NEAR(at_100(2), 0.0013, 0.51e-4);
}

/// Straight ahead k_b has no effect: its prior stays.
TEST(CramerRaoBound, keepsThePriorOfWhatTheRunDoesNotShow) {
  const reference::Commands straight{[](double) { return 1.0; }, [](double) { return 0.0; }};
  const Eigen::VectorXd bound = boundOf(reference::drive(straight, 5.0), Gains::Constant(0.02));
  EXPECT_NEAR(bound(2), 0.02, 1e-9);
  EXPECT_LT(bound.head(2).maxCoeff(), 0.01);
}

/// The information of a run in everything that is unknown: pose at the start, gains, and all input noises,
/// each divided by its deviation.
Eigen::MatrixXd denseInformation(const std::vector<Step>& steps, double prior) {
  const auto n = static_cast<Eigen::Index>(6 + 3 * steps.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Identity(n, n);
  information.diagonal().head<3>().setConstant(1.0 / (kDiffuse * kDiffuse));
  information.diagonal().segment<3>(3).setConstant(1.0 / (prior * prior));
  const Eigen::Matrix3d R_inverse = reference::laserCovariance().inverse();
  Eigen::MatrixXd pose = Eigen::MatrixXd::Zero(3, n);  // d pose / d unknowns
  pose.leftCols<3>().setIdentity();
  information += pose.transpose() * R_inverse * pose;
  Eigen::Index noise = 6;
  for (const Step& step : steps) {
    const reference::Linearised at = reference::linearise(step);
    pose = (at.F * pose).eval();
    pose.middleCols<3>(3) += at.J;
    pose.middleCols<3>(noise) += at.G * at.variance.cwiseSqrt().asDiagonal();
    noise += 3;
    if (step.laser) information += pose.transpose() * R_inverse * pose;
  }
  return information;
}

/// Schur complement: all but the gains taken out.
Gains denseBound(const std::vector<Step>& steps, double prior) {
  const Eigen::MatrixXd information = denseInformation(steps, prior);
  const Eigen::Index n = information.rows();
  std::vector<Eigen::Index> rest{0, 1, 2};
  for (Eigen::Index i = 6; i < n; ++i) rest.push_back(i);
  const auto m = static_cast<Eigen::Index>(rest.size());
  Eigen::MatrixXd nuisance(m, m);
  Eigen::MatrixXd cross(m, 3);
  for (Eigen::Index i = 0; i < m; ++i) {
    cross.row(i) = information.block<1, 3>(rest[static_cast<std::size_t>(i)], 3);
    for (Eigen::Index j = 0; j < m; ++j)
      nuisance(i, j) = information(rest[static_cast<std::size_t>(i)], rest[static_cast<std::size_t>(j)]);
  }
  const Eigen::Matrix3d gains =
      information.block<3, 3>(3, 3) - cross.transpose() * nuisance.llt().solve(cross);
  return gains.inverse().diagonal().cwiseSqrt();
}

TEST(CramerRaoBound, equalsTheDenseInformationMatrixWithoutItsNuisances) {
  // 6 to 9 s of the run: the bend, 450 noises.
  const std::vector<Step>& all = fifteenSeconds();
  const std::vector<Step> steps(all.begin() + 300, all.begin() + 450);
  for (const double prior : {0.02, 10.0}) {
    const Gains dense = denseBound(steps, prior);
    std::cout << "prior " << prior << ": " << dense.transpose() << "\n";
    EXPECT_TRUE(test_support::matrixRelativelyNear(boundOf(steps, Gains::Constant(prior)), dense, 1e-9));
  }
}

}  // namespace
}  // namespace bs_car_odometry::calibration
