// Exact moments against 100,000 particles, on every scenario of the simulator.
#include "cars.hpp"
#include "drive.hpp"

#include "bs_car_odometry/core/moment_uncertainty.hpp"
#include "bs_car_odometry/core/odometry_estimator.hpp"
#include "bs_car_odometry/simulation/scenario.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <thread>

namespace bs_car_odometry::drives {
namespace {

constexpr int kParticles = 100000;

/// Where the heading is known worse than this [rad], the rule over p(A) is beyond its reach
/// (docs/model.md, 5.5).
constexpr double kReachOfTheRule = 0.5;

/// The rectangle is driven at a fifth of the others' speed.
double rateOf(const std::string& scenario) { return scenario == "rectangle" ? 4.0 : 20.0; }

/// Relative standard errors of the particles' standard deviations of x, y, yaw: sqrt((kurtosis - 1)/(4 N)),
/// which a bent cloud has more of than a Gaussian one.
Eigen::Vector3d samplingErrors(const PoseUncertainty& cloud, const Pose2& mean) {
  Eigen::Array3d second = Eigen::Array3d::Zero();
  Eigen::Array3d fourth = Eigen::Array3d::Zero();
  for (std::size_t i = 0; i < cloud.particles(); ++i) {
    const Eigen::Array3d square = (cloud.particle(i).vector() - mean.vector()).array().square();
    second += square;
    fourth += square.square();
  }
  const auto n = static_cast<double>(cloud.particles());
  return ((n * fourth / second.square() - 1.0) / (4.0 * n)).sqrt();
}

struct Case {
  std::string scenario;
  AxleSelection axles;
  bool systematic;
};

OdometryConfiguration configured(const Case& c, Uncertainty uncertainty) {
  OdometryConfiguration configuration = odometryOf(cycab(AxleGeometry::kAckermann, 1e-5), c.axles);
  configuration.options.uncertainty = uncertainty;
  configuration.options.particles.count = kParticles;
  configuration.options.particles.threads =
      static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  if (!c.systematic) configuration.noise.systematic = {0.0, 0.0, 0.0, 0.0};
  return configuration;
}

/// The steps that a recorded drive is to an estimator.
std::vector<StepReadings> readings(const Vehicle& vehicle, const std::vector<Sample>& drive) {
  std::vector<StepReadings> steps;
  for (std::size_t i = 1; i < drive.size(); ++i) {
    StepReadings step;
    for (const Wheel wheel : kAllWheels)
      step.travel[wheel] = vehicle.calibratedMetresPerTick(wheel) *
                           static_cast<double>(drive[i].ticks[wheel] - drive[i - 1].ticks[wheel]);
    step.begin = {drive[i - 1].steering.front, vehicle.rear_steering.angle(drive[i - 1].steering.front)};
    step.end = {drive[i].steering.front, vehicle.rear_steering.angle(drive[i].steering.front)};
    steps.push_back(step);
  }
  return steps;
}

class ExactMomentsAndParticles : public testing::TestWithParam<Case> {};

/// Within 1 % in every standard deviation, about the mean, at five instants of the drive. The particles' own
/// standard error is 0.22 %.
TEST_P(ExactMomentsAndParticles, agree) {
  const OdometryConfiguration exact_configuration = configured(GetParam(), Uncertainty::kExactMoments);
  DriveSettings settings;
  settings.scenario = GetParam().scenario;
  settings.rate = rateOf(settings.scenario);
  settings.noise = NoiseModel();
  std::cout << "seed of the drive " << settings.seed << ", of the particles "
            << exact_configuration.options.particles.seed << "\n";
  const Vehicle& vehicle = exact_configuration.vehicle;
  const std::vector<StepReadings> steps = readings(vehicle, record(vehicle, settings));
  OdometryEstimator exact(exact_configuration);
  OdometryEstimator particles(configured(GetParam(), Uncertainty::kMonteCarlo));
  const auto& moments = dynamic_cast<const ExactMoments&>(exact.uncertainty());
  int judged = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    exact.step(steps[i], durationFromSeconds(1.0 / settings.rate));
    particles.step(steps[i], durationFromSeconds(1.0 / settings.rate));
    if ((i + 1) % (steps.size() / 5) != 0) continue;
    const Eigen::Vector3d expected = moments.central().diagonal().cwiseSqrt();
    const Eigen::Vector3d drawn = particles.estimate().pose_covariance.diagonal().cwiseSqrt();
    const Eigen::Vector3d difference = expected.cwiseQuotient(drawn) - Eigen::Vector3d::Ones();
    std::cout << "  step " << i + 1 << ", particles " << drawn.transpose()
              << ", exact moments over them less 1: " << 100.0 * difference.transpose() << " %\n";
    if (drawn.z() > kReachOfTheRule) break;
    const Eigen::Vector3d sampling = samplingErrors(particles.uncertainty(), particles.estimate().pose);
    for (Eigen::Index k = 0; k < 3; ++k)  // 1 %, and 3 standard errors of the particles: 400 are compared
      EXPECT_LT(std::abs(difference(k)), 0.01 + 3.0 * sampling(k)) << "component " << k;
    ++judged;
  }
  EXPECT_GT(judged, 0);
}

std::vector<Case> cases() {
  std::vector<Case> cases;
  for (const std::string& scenario : simulation::scenarioNames())
    for (const AxleSelection axles : {AxleSelection::kBoth, AxleSelection::kRear})
      for (const bool systematic : {false, true}) cases.push_back({scenario, axles, systematic});
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Scenarios, ExactMomentsAndParticles, testing::ValuesIn(cases()), [](const auto& c) {
  return c.param.scenario + "_" + name(c.param.axles) + (c.param.systematic ? "_systematic" : "_noise");
});

}  // namespace
}  // namespace bs_car_odometry::drives
