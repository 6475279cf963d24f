// P1's calibration (docs/calibration.md, 1): k_d on a straight run, then k_r and k_b with k_d as it is known.
#include "bs_car_odometry/calibration/paper_filter.hpp"

#include "simulated_drive.hpp"
#include "support/matchers.hpp"
#include "support/seeded_generator.hpp"

#include "bs_car_odometry/laboratory/chi_square.hpp"
#include "bs_car_odometry/laboratory/parallel.hpp"

#include <gmock/gmock.h>
#include <Eigen/LU>

#include <iomanip>

namespace bs_car_odometry::calibration {
namespace {

using namespace test_support;
using laboratory::meanInterval;
using systematic::kRearLeft;
using systematic::kRearRight;
using systematic::kRearTrack;

constexpr double kWheel = 0.005;  // c [m/sqrt(m)]

// --- Stage 1, the maths
// --------------------------------------------------------------------------------------------------

/// (10) and (C3) on a straight run of 50 000 pulses of the right wheel: reference values T8.
TEST(StraightRun, T08LeftGainByPulseTotals) {
  const double k_r = 1.02;
  const double k_l = 0.99;
  const double zeta_r = 2e-4;
  const double zeta_l = 2.02e-4;
  const StraightRun run{zeta_r * 50000.0, k_r / k_l * zeta_r * 50000.0};  // both wheels go as far
  const double k_d = (k_r * run.right + k_l * run.left) / (run.right + run.left);
  EXPECT_TRUE(relativelyNear(run.left / zeta_l, 51005.1005101, 1e-9));
  EXPECT_TRUE(relativelyNear(k_d, 1.0047761194, 1e-9));
  EXPECT_TRUE(relativelyNear((StraightRun{zeta_r, zeta_l}.leftGain(k_d, k_r)), 0.989702970297, 1e-9));
  EXPECT_TRUE(relativelyNear(run.leftGain(k_d, k_r), k_l, 1e-13));
}

TEST(StraightRun, derivativesOfTheLeftGain) {
  const StraightRun run{3.0, 5.0};
  EXPECT_NEAR(run.leftGain(1.1, 0.9) - run.leftGain(1.0, 0.9), 0.1 * run.leftGainByDistanceGain(), 1e-14);
  EXPECT_NEAR(run.leftGain(1.0, 1.0) - run.leftGain(1.0, 0.9), 0.1 * run.leftGainByRightGain(), 1e-14);
  EXPECT_EQ(StraightRun().leftGain(1.01, 1.02), 1.0);  // no run: equal travels
}

/// The car at 1 m/s, 50 Hz, a fix of 0.02 m after every fifth sample.
DistanceGainFilter straightRun(double metres) {
  DistanceGainFilter filter(1.0, 0.05 * 0.05);
  filter.begin(0.02 * 0.02);
  const int samples = static_cast<int>(std::lround(metres / 0.02));
  for (int i = 1; i <= samples; ++i) {
    filter.move(0.02, kWheel * kWheel * 0.02 / 2.0);
    if (i % 5 == 0) filter.update(filter.distance(), 0.02 * 0.02);
  }
  return filter;
}

TEST(DistanceGainFilter, T09Deviations) {
  const DistanceGainFilter filter = straightRun(10.0);
  EXPECT_TRUE(relativelyNear(std::sqrt(filter.covariance()(0, 0)), 0.00523789350284, 1e-9));
  EXPECT_TRUE(relativelyNear(std::sqrt(filter.gainVariance()), 0.0013813312454, 1e-9));
}

/// To the digits that are printed.
TEST(DistanceGainFilter, deviationFallsWithTheDistance) {
  for (const auto& [metres, deviation] : std::vector<std::pair<double, double>>{
           {5.0, 0.0026}, {10.0, 0.0014}, {20.0, 0.0009}, {50.0, 0.0005}}) {
    const double found = std::sqrt(straightRun(metres).gainVariance());
    EXPECT_NEAR(found, deviation, 0.00005) << metres << " m";
    // What a perfect laser would leave: the noise of both wheels' paths.
    EXPECT_GT(found, kWheel / std::sqrt(2.0 * metres)) << metres << " m";
  }
}

TEST(DistanceGainFilter, anOutlierIsBelievedLess) {
  DistanceGainFilter filter = straightRun(10.0);
  const double before = filter.gain();
  const double weight = filter.update(filter.distance() + 1.0, 0.02 * 0.02);
  EXPECT_LT(weight, 0.01);  // 1 m is 48 standard deviations off; (3/48)^2
  EXPECT_NEAR(filter.gain(), before, std::sqrt(filter.gainVariance()));
}

// --- Stage 1, from readings and laser poses
// --------------------------------------------------------------------------------------------------

simulation::TrueParameters wrongGains(const Parameters& p) {
  return simulation::withScenarioGains(p.vehicle);
}

Eigen::Vector3d rearGains(const FilterEstimate& estimate) {
  return {estimate.values[kRearRight], estimate.values[kRearLeft], estimate.values[kRearTrack]};
}

Eigen::Vector3d rearGains(const simulation::TrueParameters& truth) {
  const AxleGains& gains = truth.gains.rear;
  return {gains.k_r, gains.k_l, gains.k_b};
}

Eigen::Matrix3d rearCovariance(const FilterEstimate& estimate) {
  return estimate.covariance.block<3, 3>(kRearRight, kRearRight);
}

double trueDistanceGain(const simulation::TrueParameters& truth, const StraightRun& run) {
  return run.rightShare() * truth.gains.rear.k_r + (1.0 - run.rightShare()) * truth.gains.rear.k_l;
}

TEST(PaperFilter, isWhatTheMethodSelects) {
  Parameters p = cycab();
  EXPECT_EQ(makeFilter(p)->estimate().stage, 1);
  p.calibration.method = CalibrationMethod::kJoint;
  EXPECT_EQ(makeFilter(p)->estimate().stage, 0);
}

/// Before the drive: the prior, and what it says of k_d.
TEST(PaperFilter, beginsWithThePrior) {
  Parameters p = cycab();
  p.vehicle.gains.rear = {1.04, 0.98, 1.1};
  p.calibration.prior = {0.01, 0.02, 0.03, 0.0, 0.0};
  const FilterEstimate estimate = PaperFilter(p).estimate();
  EXPECT_EQ(rearGains(estimate), Eigen::Vector3d(1.04, 0.98, 1.1));
  const Eigen::Matrix3d expected = Eigen::Vector3d(1e-4, 4e-4, 9e-4).asDiagonal();
  EXPECT_TRUE(matrixNear(rearCovariance(estimate), expected, 1e-18));
  EXPECT_DOUBLE_EQ(estimate.k_d.rear, 1.01);
  EXPECT_DOUBLE_EQ(estimate.k_d_variance.rear, 1.25e-4);
}

/// Exact readings and poses: nothing is left over but the rounding of the counters.
TEST(PaperFilter, findsTheGainsOfACarWithoutNoise) {
  const Parameters p = cycab(0.05);
  PaperFilter filter(p);
  follow(drive(p, wrongGains(p), "straight", 1, false), filter);
  const FilterEstimate straight = filter.estimate();
  EXPECT_EQ(straight.stage, 1);
  EXPECT_NEAR(straight.k_d.rear, trueDistanceGain(wrongGains(p), filter.straightRun()),
              0.02 * std::sqrt(straight.k_d_variance.rear));
  follow(drive(p, wrongGains(p), "slalom_eight", 1, false), filter);
  const FilterEstimate end = filter.estimate();
  EXPECT_EQ(end.stage, 2);
  const Eigen::Vector3d deviation = rearCovariance(end).diagonal().cwiseSqrt();
  const Eigen::Vector3d error = rearGains(end) - rearGains(wrongGains(p));
  std::cout << "errors in standard deviations: " << error.cwiseQuotient(deviation).transpose() << "\n";
  // A twentieth of what noise would leave, as target 6 of the calibration asks.
  for (Eigen::Index i = 0; i < 3; ++i) EXPECT_LT(std::abs(error[i]), 0.05 * deviation[i]) << i;
}

}  // namespace
}  // namespace bs_car_odometry::calibration
