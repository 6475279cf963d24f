// What every covariance must obey, whatever the drive.
#include "support/matchers.hpp"
#include "support/seeded_generator.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/nearest_covariance.hpp"
#include "bs_car_odometry/core/odometry_estimator.hpp"

#include <Eigen/Eigenvalues>

namespace bs_car_odometry {
namespace {

using namespace test_support;

constexpr std::array<AxleSelection, 3> kSelections{AxleSelection::kBoth, AxleSelection::kFront,
                                                   AxleSelection::kRear};

OdometryEstimator makeEstimator(const Vehicle& vehicle, AxleSelection axles, const NoiseModel& noise) {
  OdometryConfiguration configuration;
  configuration.vehicle = vehicle;
  configuration.options.axles = axles;
  configuration.noise = noise;
  return OdometryEstimator(configuration);
}

/// A slalom of two periods over 20 m in `steps` steps; `direction` -1 drives it in reverse.
void driveSlalom(OdometryEstimator& estimator, const Vehicle& vehicle, int steps, double direction = 1.0) {
  const auto angles = [&](double part) { return slaved(vehicle, 0.3 * std::sin(4.0 * M_PI * part)); };
  for (int i = 0; i < steps; ++i) {
    StepReadings readings;
    readings.begin = angles(static_cast<double>(i) / steps);
    readings.end = angles(static_cast<double>(i + 1) / steps);
    const SteeringAngles mean = readings.mean();
    readings.travel = wheelSpeeds(vehicle, bodyTwist(vehicle, direction * 20.0 / steps, mean), mean);
    ASSERT_TRUE(estimator.step(readings, durationFromSeconds(0.02)));
    ASSERT_TRUE(isCovariance(estimator.estimate().pose_covariance));
    ASSERT_TRUE(isCovariance(estimator.estimate().twist_covariance));
  }
}

class CovarianceLaws : public testing::TestWithParam<Vehicle> {};

TEST_P(CovarianceLaws, O2_SymmetricAndPositiveAllAlong) {
  for (const AxleSelection axles : kSelections) {
    OdometryEstimator estimator = makeEstimator(GetParam(), axles, NoiseModel());
    driveSlalom(estimator, GetParam(), 400);
    EXPECT_GT(estimator.estimate().pose_covariance.determinant(), 0.0);
  }
}

/// Readings that no car would give: wheels against each other, angles up to a radian.
TEST_P(CovarianceLaws, O2_SymmetricAndPositiveOnNonsense) {
  SeededGenerator generator(2024);
  for (const AxleSelection axles : kSelections) {
    OdometryEstimator estimator = makeEstimator(GetParam(), axles, NoiseModel());
    for (int i = 0; i < 500; ++i) {
      StepReadings readings;
      for (double& travel : readings.travel.values) travel = generator.normal(0.01);
      readings.begin = slaved(GetParam(), std::tanh(generator.normal(1.0)));
      readings.end = slaved(GetParam(), std::tanh(generator.normal(1.0)));
      ASSERT_TRUE(estimator.step(readings, durationFromSeconds(0.02)));
      ASSERT_TRUE(isCovariance(estimator.estimate().pose_covariance)) << "step " << i;
      ASSERT_TRUE(isCovariance(estimator.estimate().twist_covariance)) << "step " << i;
    }
  }
}

/// One that the odometry published: its minors are above zero by rounding alone, its smallest eigenvalue is
/// -2.6e-8 of the largest.
TEST(NearestCovariance, O2_IsFoundWhereTheMinorsSayThatNothingIsWrong) {
  Eigen::Matrix3d covariance;
  covariance << 1.9371208007280375e+21, 4.2288673824422458e+21, 4.6515373127244301e+21,  //
      4.2288673824422458e+21, 9.2319071335003435e+21, 1.015462455196146e+22,             //
      4.6515373127244301e+21, 1.015462455196146e+22, 1.1169565260536919e+22;
  EXPECT_TRUE(repair(covariance));
  const Eigen::Vector3d eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly).eigenvalues();
  EXPECT_GE(eigenvalues.minCoeff(), -1e-12 * eigenvalues.maxCoeff());
}

/// The independent noise of a step does not know which way the car went: variances the same, and the path
/// mirrored.
TEST_P(CovarianceLaws, O3_ReverseAsForward) {
  for (const AxleSelection axles : kSelections) {
    OdometryEstimator forward = makeEstimator(GetParam(), axles, NoiseModel());
    OdometryEstimator reverse = makeEstimator(GetParam(), axles, NoiseModel());
    const StepReadings ahead = consistentReadings(GetParam(), 0.05, slaved(GetParam(), 0.3));
    const StepReadings back = consistentReadings(GetParam(), -0.05, slaved(GetParam(), 0.3));
    ASSERT_TRUE(forward.step(ahead, std::nullopt));
    ASSERT_TRUE(reverse.step(back, std::nullopt));
    EXPECT_TRUE(matrixNear(reverse.lastIncrement().path_covariance, forward.lastIncrement().path_covariance,
                           1e-12 * forward.lastIncrement().path_covariance.norm()));
  }
}

/// Ten times as many messages of one drive: the same covariance within 1 %.
TEST_P(CovarianceLaws, O3_MessageRateDoesNotMatter) {
  for (const AxleSelection axles : kSelections) {
    OdometryEstimator slow = makeEstimator(GetParam(), axles, NoiseModel());
    OdometryEstimator fast = makeEstimator(GetParam(), axles, NoiseModel());
    driveSlalom(slow, GetParam(), 200);
    driveSlalom(fast, GetParam(), 2000);
    const Eigen::Matrix3d expected = firstOrder(slow).noise();
    const Eigen::Vector3d sigma = expected.diagonal().cwiseSqrt();
    const Eigen::Matrix3d scale = (sigma * sigma.transpose()).cwiseInverse();
    const Eigen::Matrix3d difference = (firstOrder(fast).noise() - expected).cwiseProduct(scale);
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 0.01) << difference;
  }
}

TEST_P(CovarianceLaws, NoSystematicPartWithoutItsNoise) {
  for (const AxleSelection axles : kSelections) {
    NoiseModel noise;
    noise.systematic = {0.0, 0.0, 0.0, 0.0};
    OdometryEstimator estimator = makeEstimator(GetParam(), axles, noise);
    driveSlalom(estimator, GetParam(), 100);
    EXPECT_EQ(estimator.estimate().pose_covariance, firstOrder(estimator).noise());
    OdometryEstimator with_parameters = makeEstimator(GetParam(), axles, NoiseModel());
    driveSlalom(with_parameters, GetParam(), 100);
    EXPECT_EQ(firstOrder(with_parameters).noise(), firstOrder(estimator).noise());
    EXPECT_GT(with_parameters.estimate().pose_covariance(0, 0), estimator.estimate().pose_covariance(0, 0));
  }
}

/// Systematic errors grow with the distance, not with its root: twice as far, twice the deviation.
TEST_P(CovarianceLaws, SystematicPartGrowsWithTheDistance) {
  NoiseModel noise = noNoise();
  noise.systematic.k_r = noise.systematic.k_l = 0.01;
  Vehicle vehicle = GetParam();
  vehicle.rear_steering.coefficients = {0.0};
  const StepReadings straight = consistentReadings(vehicle, 0.02, {});
  OdometryEstimator estimator = makeEstimator(vehicle, AxleSelection::kRear, noise);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(estimator.step(straight, std::nullopt));
  const double once = estimator.estimate().pose_covariance(0, 0);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(estimator.step(straight, std::nullopt));
  EXPECT_TRUE(relativelyNear(estimator.estimate().pose_covariance(0, 0), 4.0 * once, 1e-12));
}

INSTANTIATE_TEST_SUITE_P(FourGeometries, CovarianceLaws, testing::ValuesIn(fourGeometries()),
                         [](const auto& vehicle) { return vehicle.param.name; });

}  // namespace
}  // namespace bs_car_odometry
