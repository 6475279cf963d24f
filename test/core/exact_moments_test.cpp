// Exact moments against draws of the very model that they claim: independent Gaussian increments, parameters
// drawn once a drive.
#include "support/matchers.hpp"
#include "support/seeded_generator.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/moment_uncertainty.hpp"
#include "bs_car_odometry/core/odometry_estimator.hpp"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <iostream>
#include <vector>

namespace bs_car_odometry {
namespace {

using namespace test_support;

struct Step {
  BodyMotion motion;
  Eigen::Matrix3d noise_root;
  SystematicSensitivity J_motion;  ///< to a
};

struct Drive {
  std::vector<Step> steps;
  Pose2 end;
  Eigen::Matrix3d published;
};

/// 60 m of circle at 0.3 rad with every wheel, where the noise ellipse is thin: 1 cm against 0.7 m.
Drive circle(const SystematicNoise& systematic) {
  OdometryConfiguration configuration;
  configuration.vehicle = cycab();
  configuration.options.uncertainty = Uncertainty::kExactMoments;
  configuration.noise.systematic = systematic;
  OdometryEstimator estimator(configuration);
  const SystematicRoot root(systematicCovariance(configuration.noise.systematic));
  const StepReadings readings = consistentReadings(cycab(), 0.04, slaved(cycab(), 0.3));
  Drive drive;
  for (int i = 0; i < 1500; ++i) {
    estimator.step(readings, std::nullopt);
    const BodyIncrement& increment = estimator.lastIncrement();
    drive.steps.push_back(
        {increment.motion, increment.path_covariance.llt().matrixL(), root(increment.J_motion_systematic)});
  }
  drive.end = estimator.estimate().pose;
  drive.published = estimator.estimate().pose_covariance;
  return drive;
}

Eigen::Vector3d drawError(const Drive& drive, SeededGenerator& generator) {
  Eigen::Matrix<double, systematic::kCount, 1> a;
  for (double& component : a) component = generator.normal(1.0);
  Pose2 pose;
  for (const Step& step : drive.steps) {
    const Eigen::Vector3d n(generator.normal(1.0), generator.normal(1.0), generator.normal(1.0));
    pose = pose * exp(step.motion + step.noise_root * n + step.J_motion * a);
  }
  return pose.vector() - drive.end.vector();
}

/// Mean NEES of the dead-reckoned pose: 3 when the published matrix is E[e e^T].
double meanNees(const SystematicNoise& systematic) {
  constexpr int kDraws = 10000;
  SeededGenerator generator(5);
  const Drive drive = circle(systematic);
  const Eigen::Matrix3d information = drive.published.inverse();
  double sum = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d error = drawError(drive, generator);
    sum += error.dot(information * error);
  }
  std::cout << "  heading " << std::sqrt(drive.published(2, 2)) << " rad, mean NEES " << sum / kDraws
            << std::endl;
  return sum / kDraws;
}

/// Of 10,000 draws: 3.3 standard deviations of the mean of chi-squares are 0.08, and a bent cloud has heavier
/// tails than they have.
constexpr double kSampling = 0.15;

TEST(ExactMomentsDraws, NoiseAlone) { EXPECT_NEAR(meanNees({0.0, 0.0, 0.0, 0.0}), 3.0, kSampling); }

TEST(ExactMomentsDraws, SteeringOffset) { EXPECT_NEAR(meanNees({0.0, 0.0, 0.0, 0.003}), 3.0, kSampling); }

TEST(ExactMomentsDraws, WheelGains) { EXPECT_NEAR(meanNees({0.01, 0.01, 0.0, 0.0}), 3.0, kSampling); }

/// With several parameters that bend the drive by 0.3 rad together, mixed moments beyond the fifth degree are
/// missed: in the thinnest direction the variance is 30 % too small, a millimetre and a half.
TEST(ExactMomentsDraws, AllParameters) { EXPECT_NEAR(meanNees({0.01, 0.01, 0.02, 0.003}), 3.3, 0.3); }

}  // namespace
}  // namespace bs_car_odometry
