// Which sensor is wrong: T15 of the reference values, and what p(A) allows (docs/model.md, 6.1).
#include "vehicles.hpp"

#include "bs_car_odometry/core/fault_isolation.hpp"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {
namespace {

using namespace test_support;

constexpr std::size_t kRearRightSensor = sensor(Wheel::kRearRight);

/// The step of T15 with an error of the right rear wheel [m]; a gain of 1 moves a wheel by a metre, an offset
/// an axle.
ParameterEvidence evidenceOfT15(double slip) {
  const FitMatrix<3> H = fitEquations(FitGeometry(cycab()), {0.25, -0.25}).H;
  const Eigen::Vector4d travels(0.039360994367, 0.0640523777058, 0.039360994367, 0.0640523777058 + slip);
  FitCovariance R;
  R.wheels.setConstant(1e-6);
  const Eigen::Array2d axle_travel(0.5 * (travels(0) + travels(1)), 0.5 * (travels(2) + travels(3)));
  R.axles = (axle_travel * 5e-3).square() + 2e-4 * 2e-4;
  R.shared = 0.0;
  const FitSolution fit = solveFit(H, R, travels);
  Eigen::Matrix<double, 6, 1> weights;
  weights << R.wheels.inverse(), R.axles.inverse();
  const FitMatrix<3> W = weights.asDiagonal() * H;
  const Eigen::Matrix<double, 6, 6> M =
      Eigen::Matrix<double, 6, 6>(weights.asDiagonal()) - W * fit.P * W.transpose();
  FitMatrix<systematic::kCount> D = FitMatrix<systematic::kCount>::Zero();
  const std::array<systematic::Index, kSensors> parameter{systematic::kFrontLeft,   systematic::kFrontRight,
                                                          systematic::kRearLeft,    systematic::kRearRight,
                                                          systematic::kFrontOffset, systematic::kRearOffset};
  for (std::size_t i = 0; i < kSensors; ++i) D(static_cast<Eigen::Index>(i), parameter[i]) = 1.0;
  return {D.transpose() * M * D, -D.transpose() * weights.cwiseProduct(fit.residual), fit.chi_square};
}

TEST(FaultIsolation, FallsAreTheNormalisedResidualsOfT15) {
  const SensorTests tests = testSensors(evidenceOfT15(0.008), SystematicCovariance::Zero());
  EXPECT_NEAR(tests.chi_square, 39.393236581, 1e-8);
  const std::array<double, kSensors> w{-1.67521542516, -3.86335667308, -1.7479833415,
                                       6.27640315634,  -1.6099712672,  3.5693292921};
  for (std::size_t i = 0; i < kSensors; ++i) EXPECT_NEAR(tests.sensors[i].fall, w[i] * w[i], 1e-8) << i;
  EXPECT_NEAR(tests.sensors[kRearRightSensor].deviation, -0.008, 1e-10) << "what the gain lacks";
  for (std::size_t i = 0; i < kSensors; ++i) {
    if (i != kRearRightSensor) {
      EXPECT_GT(tests.chi_square - tests.sensors[i].fall, 24.0) << "dropping it explains little";
    }
  }
}

/// Deviations in units of a metre, so that 8 mm are nothing, and 80 are a fault.
TEST(FaultIsolation, SuspectsTheWheelThatSlips) {
  EXPECT_EQ(suspects(testSensors(evidenceOfT15(0.008), SystematicCovariance::Zero())).count, 0u)
      << "39 is not beyond doubt in a day";
  const Suspects found = suspects(testSensors(evidenceOfT15(0.08), SystematicCovariance::Zero()));
  ASSERT_EQ(found.count, 1u);
  EXPECT_EQ(found.sensors[0], kRearRightSensor);
}

TEST(FaultIsolation, WhatTheParametersAllowIsNoFault) {
  const ParameterEvidence evidence = evidenceOfT15(0.08);
  SystematicCovariance prior = SystematicCovariance::Zero();
  prior(systematic::kRearRight, systematic::kRearRight) = 0.08 * 0.08;  // one standard deviation
  const SensorTests tests = testSensors(evidence, prior);
  // One standard deviation beside the noise of a millimetre.
  EXPECT_NEAR(tests.sensors[kRearRightSensor].fall, 1.0, 0.001);
  EXPECT_EQ(suspects(tests).count, 0u);
}

/// A dense computation of (F1): readings whose parameters have been integrated out.
TEST(FaultIsolation, ChiSquareAllowsForTheParameters) {
  const ParameterEvidence e = evidenceOfT15(0.02);
  SystematicCovariance prior = SystematicCovariance::Zero();
  for (Eigen::Index i = 0; i < systematic::kCount; ++i) prior(i, i) = 1e-4 * static_cast<double>(i + 1);
  const SystematicCovariance posterior = (prior.inverse() + e.information).inverse();
  const double expected = e.chi_square - e.gradient.dot(posterior * e.gradient);
  EXPECT_NEAR(testSensors(e, prior).chi_square, expected, 1e-9 * e.chi_square);
}

/// What a car's model leaves out is in every row alike, and nobody's fault.
TEST(FaultIsolation, WhatNoSensorExplainsIsNobodysFault) {
  SensorTests tests;
  tests.chi_square = 1000.0;
  for (SensorTest& test : tests.sensors) test = {0.2, 0.01, 400.0};
  EXPECT_EQ(suspects(tests).count, 0u);
  tests.sensors[2].fall = 900.0;
  EXPECT_EQ(suspects(tests).count, 1u);
  tests.sensors[4].fall = 850.0;
  const Suspects two = suspects(tests);
  ASSERT_EQ(two.count, 2u) << "which of them is not known";
  EXPECT_EQ(two.sensors[0], 2u) << "the likelier first";
  tests.sensors[2].deviation = tests.sensors[4].deviation = 0.01;
  EXPECT_EQ(suspects(tests).count, 0u) << "too little to be a fault";
}

}  // namespace
}  // namespace bs_car_odometry
