#include "bs_car_odometry/simulation/true_parameters.hpp"

#include "test_vehicles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace bs_car_odometry::simulation {
namespace {

Vehicle calibratedCar(RearSteering::Source source) {
  Vehicle vehicle = cycab();
  vehicle.gains.front = {1.1, 0.9, 1.2};
  vehicle.gains.rear = {0.8, 1.3, 0.7};
  vehicle.steering.front = {1.5, 0.01};
  vehicle.steering.rear = {0.5, -0.02};
  vehicle.rear_steering.source = source;
  return vehicle;
}

TEST(TrueParameters, scenarioGainsMultiplyTheConfiguredOnes) {
  const TrueParameters truth = withScenarioGains(calibratedCar(RearSteering::Source::kPolynomial));
  EXPECT_DOUBLE_EQ(truth.gains.front.k_r, 1.1 * 1.02);
  EXPECT_DOUBLE_EQ(truth.gains.front.k_l, 0.9 * 0.99);
  EXPECT_DOUBLE_EQ(truth.gains.front.k_b, 1.2 * 1.03);
  EXPECT_DOUBLE_EQ(truth.gains.rear.k_r, 0.8 * 1.02);
  EXPECT_EQ(truth.steering.rear.offset, -0.02);
}

TEST(TrueParameters, asConfiguredIsTheConfiguration) {
  const TrueParameters truth = asConfigured(calibratedCar(RearSteering::Source::kMeasured));
  EXPECT_EQ(truth.gains.rear.k_b, 0.7);
  EXPECT_EQ(truth.steering.front.scale, 1.5);
}

/// Variances and the covariance of the axles' k_r over 20000 draws; relative standard error 1 %.
TEST(TrueParameters, drawsHaveTheStandardDeviationsOfTheSystematicNoise) {
  constexpr int kDraws = 20000;
  const Vehicle vehicle = calibratedCar(RearSteering::Source::kMeasured);
  const SystematicNoise noise{0.01, 0.02, 0.03, 0.004};
  std::array<double, 8> variance{};
  double between_axles = 0.0;
  for (std::uint64_t seed = 0; seed < kDraws; ++seed) {
    const TrueParameters truth = drawnFrom(noise, vehicle, seed);
    for (Axle axle : kAllAxles) {
      const AxleGains& gains = truth.gains[axle];
      const std::array<double, 4> errors{
          (gains.k_r - vehicle.gains[axle].k_r) / noise.k_r.std(),
          (gains.k_l - vehicle.gains[axle].k_l) / noise.k_l.std(),
          (gains.k_b - vehicle.gains[axle].k_b) / noise.k_b.std(),
          (truth.steering[axle].offset - vehicle.steering[axle].offset) / 0.004};
      for (std::size_t i = 0; i < 4; ++i) variance[4 * index(axle) + i] += errors[i] * errors[i] / kDraws;
    }
    between_axles +=
        (truth.gains.front.k_r - 1.1) * (truth.gains.rear.k_r - 0.8) / (noise.k_r.variance()) / kDraws;
  }
  for (double v : variance) EXPECT_NEAR(v, 1.0, 0.04);
  EXPECT_NEAR(between_axles, 0.0, 0.03);
}

// p(A) may have any shape: the parameters fill the range of a uniform one and keep it.
TEST(TrueParameters, drawsComeFromTheDistributions) {
  constexpr int kDraws = 4000;
  const Vehicle vehicle = calibratedCar(RearSteering::Source::kMeasured);
  const SystematicNoise noise{Distribution::uniform(0.01), Distribution::uniform(0.02),
                              Distribution::uniform(0.03), Distribution::uniform(0.004)};
  std::array<double, 8> largest{};
  for (std::uint64_t seed = 0; seed < kDraws; ++seed) {
    const TrueParameters truth = drawnFrom(noise, vehicle, seed);
    for (Axle axle : kAllAxles) {
      const AxleGains& gains = truth.gains[axle];
      const AxleGains& nominal = vehicle.gains[axle];
      const std::array<double, 4> errors{
          (gains.k_r - nominal.k_r) / 0.01, (gains.k_l - nominal.k_l) / 0.02,
          (gains.k_b - nominal.k_b) / 0.03,
          (truth.steering[axle].offset - vehicle.steering[axle].offset) / 0.004};
      for (std::size_t i = 0; i < 4; ++i) {
        double& slot = largest[4 * index(axle) + i];
        slot = std::max(slot, std::abs(errors[i]));
      }
    }
  }
  // 1e-13: differences of numbers near one. A largest of 4000 below 0.99 has a chance of 1e-17.
  for (double l : largest) {
    EXPECT_LE(l, 1.0 + 1e-13);
    EXPECT_GT(l, 0.99);
  }
}

TEST(TrueParameters, aSlavedRearAxleHasNoOffsetToDraw) {
  const Vehicle slaved = calibratedCar(RearSteering::Source::kPolynomial);
  const Vehicle measured = calibratedCar(RearSteering::Source::kMeasured);
  EXPECT_EQ(drawnFrom({}, slaved, 4).steering.rear.offset, -0.02);
  EXPECT_NE(drawnFrom({}, measured, 4).steering.rear.offset, -0.02);
  EXPECT_EQ(drawnFrom({}, slaved, 4).gains.rear.k_b, drawnFrom({}, measured, 4).gains.rear.k_b);
}

}  // namespace
}  // namespace bs_car_odometry::simulation
