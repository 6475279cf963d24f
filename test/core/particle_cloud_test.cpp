// Particles against reference values and against the laws that every uncertainty obeys.
#include "support/matchers.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/odometry_estimator.hpp"
#include "bs_car_odometry/core/particle_cloud.hpp"
#include "bs_car_odometry/core/particle_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

namespace bs_car_odometry {
namespace {

using namespace test_support;

constexpr std::array<AxleSelection, 3> kSelections{AxleSelection::kBoth, AxleSelection::kFront,
                                                   AxleSelection::kRear};

OdometryConfiguration particleConfiguration(const Vehicle& vehicle, AxleSelection axles, int count) {
  OdometryConfiguration configuration;
  configuration.vehicle = vehicle;
  configuration.options.axles = axles;
  configuration.options.uncertainty = Uncertainty::kMonteCarlo;
  configuration.options.particles.count = count;
  std::cout << "seed " << configuration.options.particles.seed << "\n";
  return configuration;
}

/// One step of a model, with what its uncertainty is told.
struct Step {
  Step(const OdometryConfiguration& configuration, const StepReadings& step_readings)
      : readings(step_readings), model(makeOdometryModel(configuration)) {
    std::visit([&](const auto& m) { m.update(readings, increment); }, model);
    moved = advance(Pose2(), increment.motion);
  }
  UncertainStep uncertain() const { return {moved, increment, J_motion, readings, model}; }

  StepReadings readings;
  OdometryModel model;
  BodyIncrement increment;
  PoseStep moved;
  SystematicSensitivity J_motion{SystematicSensitivity::Zero()};
};

/// Sum of the sources' covariances.
Eigen::Matrix3d independentNoise(const StepNoise& noise, const NoiseModel& model) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < 4; ++i) {
    const Eigen::Vector3d column = noise.J_motion_wheel.col(i);
    sum += model.wheel.variance() * noise.wheel_path.values[static_cast<std::size_t>(i)] * column *
           column.transpose();
  }
  for (const Axle axle : kAllAxles) {
    const Eigen::Vector3d column = noise.J_motion_slip.col(static_cast<Eigen::Index>(index(axle)));
    sum += model.lateral.variance() * noise.axle_path[axle] * column * column.transpose();
  }
  return sum;
}

std::vector<Vehicle> everyVehicle() {
  std::vector<Vehicle> vehicles = fourGeometries();
  for (const Vehicle& vehicle : fourGeometries()) vehicles.push_back(withMeasuredRear(vehicle));
  Vehicle three_wheels = cycab();
  three_wheels.metres_per_tick[Wheel::kFrontLeft] = 0.0;
  vehicles.push_back(three_wheels);
  return vehicles;
}

TEST(StepNoise, sourcesAddUpToTheCovarianceOfTheStep) {
  for (const Vehicle& vehicle : everyVehicle())
    for (const AxleSelection axles : kSelections) {
      if (axles == AxleSelection::kFront && !vehicle.hasEncoder(Wheel::kFrontLeft)) continue;
      SCOPED_TRACE(vehicle.name);
      OdometryConfiguration configuration = particleConfiguration(vehicle, axles, 100);
      configuration.noise.steering.angle = configuration.noise.rear_law = 0.0;
      StepReadings readings = consistentReadings(vehicle, -0.05, slaved(vehicle, 0.3));
      readings.travel[Wheel::kRearRight] += 0.001;  // residuals change nothing
      const Step step(configuration, readings);
      const StepNoise noise =
          std::visit([&](const auto& model) { return model.noiseSources(readings); }, step.model);
      const Eigen::Matrix3d& expected = step.increment.path_covariance;
      EXPECT_TRUE(
          matrixNear(independentNoise(noise, configuration.noise), expected, 1e-12 * expected.norm()));
    }
}

/// A vehicle and the axles that its odometry uses.
struct Case {
  Vehicle vehicle;
  AxleSelection axles;
};

/// With a hub offset the directions of an axle's wheels depend on the other axle's angle as well, which the
/// derivatives of one axle's odometry leave out.
std::vector<Case> casesWithExactDerivatives() {
  std::vector<Case> cases;
  for (const Vehicle& vehicle : everyVehicle())
    for (const AxleSelection axles : kSelections) {
      if (axles != AxleSelection::kBoth && vehicle.hub_offset.front != 0.0) continue;
      if (axles == AxleSelection::kFront && !vehicle.hasEncoder(Wheel::kFrontLeft)) continue;
      cases.push_back({vehicle, axles});
    }
  return cases;
}

/// Errors so small that the motion is linear in them.
OdometryConfiguration withSmallErrors(const Case& c) {
  OdometryConfiguration configuration = particleConfiguration(c.vehicle, c.axles, 100);
  configuration.noise.steering.angle = 1e-5;
  configuration.noise.rear_law = 2e-5;
  configuration.noise.wheel = configuration.noise.lateral = 1e-5;
  return configuration;
}

using AngleColumns = Eigen::Matrix<float, 3, 5, Eigen::RowMajor>;

TEST(ParticlePlan, anglesActAsTheOffsetsOfTheirSensors) {
  for (const Case& c : casesWithExactDerivatives()) {
    SCOPED_TRACE(c.vehicle.name + ", axles " + std::to_string(static_cast<int>(c.axles)));
    const OdometryConfiguration configuration = withSmallErrors(c);
    const Step step(configuration, consistentReadings(c.vehicle, 0.05, slaved(c.vehicle, 0.3)));
    const ParticlePlan plan = ParticlePlanner(configuration).plan(step.uncertain());
    const Eigen::Matrix<double, 3, 5> C = Eigen::Map<const AngleColumns>(plan.angles.data()).cast<double>();
    const SystematicSensitivity& J = step.increment.J_motion_systematic;
    // Of columns of some centimetres per radian; differences over 20 microradians are good to 1e-11.
    EXPECT_TRUE(matrixNear(C.col(0), J.col(systematic::kFrontOffset), 1e-8));
    if (c.vehicle.rear_steering.source == RearSteering::Source::kMeasured) {
      EXPECT_TRUE(matrixNear(C.col(2), J.col(systematic::kRearOffset), 1e-8));
    }
  }
}

/// But for pivot axles, where the fit's covariance leaves out that the wheels turn with their axle's angle.
TEST(ParticlePlan, columnsAddUpToTheCovarianceOfTheStep) {
  for (const Case& c : casesWithExactDerivatives()) {
    if (c.vehicle.axle_geometry == AxleGeometry::kPivot && c.axles == AxleSelection::kBoth) continue;
    SCOPED_TRACE(c.vehicle.name + ", axles " + std::to_string(static_cast<int>(c.axles)));
    const OdometryConfiguration configuration = withSmallErrors(c);
    const Step step(configuration, consistentReadings(c.vehicle, 0.05, slaved(c.vehicle, 0.3)));
    const ParticlePlanner planner(configuration);
    const ParticlePlan plan = planner.plan(step.uncertain());
    const Eigen::Matrix3d root =
        Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(plan.gaussian.data()).cast<double>();
    const Eigen::Matrix<double, 3, 5> C = Eigen::Map<const AngleColumns>(plan.angles.data()).cast<double>();
    Eigen::Matrix3d sum = root * root.transpose();
    for (const Axle axle : kAllAxles) {
      const Eigen::Vector3d column = C.col(axle == Axle::kFront ? 0 : 2);
      sum += planner.angleError(axle).variance() * configuration.noise.steering.correlation_length /
             plan.angle_path[axle] * column * column.transpose();
    }
    const Eigen::Matrix3d& expected = step.increment.path_covariance;
    EXPECT_TRUE(matrixNear(sum, expected, 1e-6 * expected.norm()));  // floats
  }
}

/// One wheel factor for both wheels of the rear axle, uniform within 1 %.
SystematicPrior commonRadius(const OdometryConfiguration& configuration) {
  using namespace systematic;
  SystematicCovariance covariance = SystematicCovariance::Zero();
  covariance.block<2, 2>(kRearRight, kRearRight).setConstant(1e-4 / 3.0);
  SystematicPrior prior(covariance, configuration);
  prior.shape[kRearRight] = Distribution::uniform(0.01);
  return prior;
}

double straightSpread(bool redrawn) {
  OdometryConfiguration configuration = particleConfiguration(ordinaryCar(), AxleSelection::kRear, 20000);
  configuration.noise = noNoise();
  ParticleCloud cloud(configuration);
  const SystematicPrior prior = commonRadius(configuration);
  cloud.setSystematic(prior, SystematicCovariance::Zero());
  const Step step(configuration, consistentReadings(configuration.vehicle, 0.04, {0.0, 0.0}));
  for (int i = 0; i < 500; ++i) {
    if (redrawn) cloud.setSystematic(prior, SystematicCovariance::Zero());
    cloud.advance(step.uncertain());
  }
  return std::sqrt(cloud.total()(0, 0));
}

/// Four standard errors of a standard deviation from N numbers of this kurtosis.
double fourErrors(double kurtosis, int count) { return 4.0 * std::sqrt((kurtosis - 1.0) / (4.0 * count)); }

TEST(ReferenceValues, T18_parametersThatStayAndParametersThatAreRedrawn) {
  EXPECT_TRUE(relativelyNear(straightSpread(false), 0.115470053838, fourErrors(1.8, 20000)));
  EXPECT_TRUE(relativelyNear(straightSpread(true), 0.00516397779494, fourErrors(3.0, 20000)));
}

TEST(ReferenceValues, T19_independentWheelsAndTrack) {
  constexpr int kCount = 100000;
  OdometryConfiguration configuration = particleConfiguration(ordinaryCar(), AxleSelection::kRear, kCount);
  configuration.vehicle.track.rear = 1.2;
  configuration.options.motion = Motion::kPaper;
  configuration.noise = noNoise();
  configuration.noise.systematic.k_r = configuration.noise.systematic.k_l =
      configuration.noise.systematic.k_b = Distribution::uniform(0.01);
  OdometryEstimator estimator(configuration);
  StepReadings readings;
  readings.travel[Wheel::kRearRight] = 0.06;
  readings.travel[Wheel::kRearLeft] = 0.04;
  for (int i = 0; i < 200; ++i) estimator.step(readings, durationFromSeconds(0.02));
  const Eigen::Vector3d expected(0.200612553998, 0.162058854807, 0.0720082299823);
  const Eigen::Vector3d std = estimator.estimate().pose_covariance.diagonal().cwiseSqrt();
  // The expected values are to first order, 0.06 % from those of 4e5 draws.
  for (Eigen::Index i = 0; i < 3; ++i)
    EXPECT_TRUE(relativelyNear(std(i), expected(i), fourErrors(3.0, kCount) + 6e-4));
}

TEST(ReferenceValues, T20_uniformSteeringErrorThatIsNotSmall) {
  constexpr int kCount = 1000000;
  OdometryConfiguration configuration = particleConfiguration(pivotCar(), AxleSelection::kFront, kCount);
  configuration.vehicle.base_link_x = configuration.vehicle.wheelbase;  // the front axle's middle
  configuration.noise = noNoise();
  configuration.noise.steering.angle = Distribution::uniform(0.1);
  configuration.noise.steering.correlation_length = 1e6;  // one draw for the step
  OdometryEstimator estimator(configuration);
  StepReadings readings;
  readings.travel.values.fill(0.5);
  readings.begin = readings.end = {0.2, -0.2};
  estimator.step(readings, durationFromSeconds(0.02));
  const Eigen::Matrix3d covariance = estimator.estimate().pose_covariance;
  const Pose2 mean = estimator.estimate().pose;
  EXPECT_NEAR(mean.x, 0.489216975036, 4.0 * std::sqrt(3.34e-5 / kCount));
  EXPECT_NEAR(mean.y, 0.099169190381, 4.0 * std::sqrt(7.99e-4 / kCount));
  EXPECT_TRUE(relativelyNear(covariance(0, 0), 3.33583988451e-05, 2.0 * fourErrors(2.2, kCount)));
  EXPECT_TRUE(relativelyNear(covariance(1, 1), 0.000798864616675, 2.0 * fourErrors(1.8, kCount)));
}

/// A drive with everything in it, standing, reversing and turning.
template <typename Visit>
void drive(OdometryEstimator& estimator, const Vehicle& vehicle, const Visit& visit) {
  for (int i = 0; i < 60; ++i) {
    const double travel = i % 20 == 0 ? 0.0 : (i < 45 ? 0.05 : -0.03);
    estimator.step(consistentReadings(vehicle, travel, slaved(vehicle, 0.3 * std::sin(0.1 * i))),
                   durationFromSeconds(0.02));
    if (i == 30) estimator.inflate(durationFromSeconds(0.001));
    if (i == 40) estimator.setSystematicCovariance(1e-4 * SystematicCovariance::Identity());
    visit(estimator);
  }
}

OdometryConfiguration everyDistribution(int count) {
  OdometryConfiguration configuration = particleConfiguration(unequalCar(), AxleSelection::kBoth, count);
  configuration.initial_pose.covariance.diagonal() << 0.01, 0.02, 0.001;
  NoiseModel& noise = configuration.noise;
  noise.wheel = Distribution::gaussian(0.005, 0.006);
  noise.lateral = Distribution::studentT(0.0005, 5.0);
  noise.rear_law = Distribution::triangular(0.002);
  noise.systematic.k_r = Distribution::uniform(0.01);
  return configuration;
}

TEST(ParticleCloud, isTheSameOnAnyNumberOfThreads) {
  constexpr int kCount = 1001;  // with a last block that is not full
  OdometryConfiguration configuration = everyDistribution(kCount);
  OdometryEstimator one(configuration);
  configuration.options.particles.threads = 2;
  OdometryEstimator two(configuration);
  configuration.options.particles.threads = 7;  // more than there are blocks
  OdometryEstimator seven(configuration);
  for (OdometryEstimator* estimator : {&one, &two, &seven})
    drive(*estimator, configuration.vehicle, [](const OdometryEstimator&) {});
  for (const OdometryEstimator* other : {&two, &seven}) {
    EXPECT_EQ(one.estimate().pose_covariance, other->estimate().pose_covariance);
    EXPECT_EQ(one.estimate().pose.vector(), other->estimate().pose.vector());
    for (std::size_t i = 0; i < kCount; ++i)
      ASSERT_EQ(one.uncertainty().particle(i).vector(), other->uncertainty().particle(i).vector());
  }
}

TEST(ParticleCloud, aLargerCloudBeginsWithTheSmallerOne) {
  const OdometryConfiguration small = everyDistribution(300);
  const OdometryConfiguration large = everyDistribution(700);
  OdometryEstimator few(small);
  OdometryEstimator many(large);
  for (OdometryEstimator* estimator : {&few, &many})
    drive(*estimator, small.vehicle, [](const OdometryEstimator&) {});
  for (std::size_t i = 0; i < 300; ++i)
    ASSERT_EQ(few.uncertainty().particle(i).vector(), many.uncertainty().particle(i).vector());
}

TEST(ParticleCloud, anotherSeedIsAnotherCloud) {
  OdometryConfiguration configuration = everyDistribution(300);
  OdometryEstimator one(configuration);
  configuration.options.particles.seed = 2;
  OdometryEstimator other(configuration);
  EXPECT_NE(one.uncertainty().particle(0).vector(), other.uncertainty().particle(0).vector());
}

TEST(ParticleCloud, resetGivesTheFirstDriveAgain) {
  const OdometryConfiguration configuration = everyDistribution(300);
  OdometryEstimator estimator(configuration);
  const auto run = [&] {
    for (int i = 0; i < 20; ++i)
      estimator.step(consistentReadings(configuration.vehicle, 0.05, slaved(configuration.vehicle, 0.2)),
                     durationFromSeconds(0.02));
    return estimator.estimate().pose_covariance;
  };
  const Eigen::Matrix3d first = run();
  estimator.reset();
  EXPECT_EQ(run(), first);
}

TEST(ParticleCloud, standsStillBitForBit) {
  const OdometryConfiguration configuration = everyDistribution(300);
  OdometryEstimator estimator(configuration);
  drive(estimator, configuration.vehicle, [](const OdometryEstimator&) {});
  const Eigen::Matrix3d covariance = estimator.estimate().pose_covariance;
  const Pose2 particle = estimator.uncertainty().particle(7);
  StepReadings readings;
  readings.begin = readings.end = slaved(configuration.vehicle, 0.2);
  for (int i = 0; i < 1000; ++i) estimator.step(readings, durationFromSeconds(0.01));
  EXPECT_EQ(estimator.estimate().pose_covariance, covariance);
  EXPECT_EQ(estimator.uncertainty().particle(7).vector(), particle.vector());
}

TEST(ParticleCloud, covarianceIsOneThroughoutAndTheMeanThatOfTheParticles) {
  const OdometryConfiguration configuration = everyDistribution(1000);
  OdometryEstimator estimator(configuration);
  drive(estimator, configuration.vehicle, [](const OdometryEstimator& e) {
    ASSERT_TRUE(isCovariance(e.estimate().pose_covariance));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < 1000; ++i) sum += e.uncertainty().particle(i).vector();
    ASSERT_TRUE(matrixNear(e.estimate().pose.vector(), 1e-3 * sum, 1e-12));
  });
}

TEST(ParticleCloud, withoutUncertaintyIsOnePose) {
  OdometryConfiguration configuration = particleConfiguration(cycab(), AxleSelection::kBoth, 300);
  configuration.noise = noNoise();
  OdometryEstimator estimator(configuration);
  for (int i = 0; i < 200; ++i) {
    estimator.step(consistentReadings(cycab(), 0.05, slaved(cycab(), 0.3 * std::sin(0.1 * i))), std::nullopt);
    // Single precision in every step: 1e-7 of 200 steps of 0.05 m.
    ASSERT_TRUE(matrixNear(estimator.estimate().pose.vector(), estimator.deadReckoned().vector(), 1e-6));
    ASSERT_TRUE(matrixNear(estimator.estimate().pose_covariance, Eigen::Matrix3d::Zero(), 1e-24));
  }
}

TEST(ParticleCloud, initialCovarianceIsDrawnAndInflationAdded) {
  constexpr int kCount = 100000;
  OdometryConfiguration configuration = particleConfiguration(cycab(), AxleSelection::kBoth, kCount);
  Eigen::Matrix3d& expected = configuration.initial_pose.covariance;
  expected << 0.04, 0.01, 0.003, 0.01, 0.02, -0.002, 0.003, -0.002, 0.001;
  configuration.initial_pose.x = 1e6;
  ParticleCloud cloud(configuration);
  cloud.reset({1e6, -1e6, 2.0}, expected);
  const double tolerance = 2.0 * fourErrors(3.0, kCount);
  EXPECT_TRUE(matrixNear(cloud.total(), expected, tolerance * 0.04));
  EXPECT_NEAR(cloud.mean()->x, 1e6, 4.0 * 0.2 / std::sqrt(kCount));
  const Eigen::Matrix3d singular = Eigen::Vector3d(0.5, 0.0, 0.0).asDiagonal();
  const Eigen::Matrix3d before = cloud.total();
  const Pose2 mean = *cloud.mean();
  cloud.inflate(singular);
  EXPECT_EQ(cloud.total(), before + singular);
  EXPECT_EQ(cloud.mean()->vector(), mean.vector());  // no step of the pose
}

TEST(ParticleCloud, otherParametersLeaveThePosesWhereTheyAre) {
  const OdometryConfiguration configuration = everyDistribution(500);
  ParticleCloud cloud(configuration);
  cloud.reset({}, 0.01 * Eigen::Matrix3d::Identity());
  const Step step(configuration, consistentReadings(configuration.vehicle, 0.5, {0.0, 0.01}));
  cloud.advance(step.uncertain());
  const Eigen::Matrix3d before = cloud.total();
  cloud.setSystematic(SystematicPrior(SystematicCovariance::Zero(), configuration),
                      SystematicCovariance::Zero());
  EXPECT_EQ(cloud.total(), before);
}

TEST(ParticleCloud, quantilesOfAGaussian) {
  constexpr int kCount = 20000;
  OdometryConfiguration configuration = particleConfiguration(cycab(), AxleSelection::kBoth, kCount);
  ParticleCloud cloud(configuration);
  cloud.reset({5.0, 0.0, 7.0}, Eigen::Vector3d(0.04, 1.0, 0.0001).asDiagonal());
  const PoseQuantiles quantiles = *cloud.quantiles();
  for (std::size_t k = 0; k < PoseQuantiles::kLevels.size(); ++k) {
    const double z = static_cast<double>(k) - 3.0;
    // Four standard errors, sqrt(p (1-p) / n) over the density, of 10,000 numbers; at most 0.33 at 3 sigma.
    const double p = PoseQuantiles::kLevels[k];
    const double error = 4.0 * std::sqrt(p * (1.0 - p) / 1e4) * std::sqrt(2.0 * M_PI) * std::exp(0.5 * z * z);
    EXPECT_NEAR((quantiles.x[k] - 5.0) / 0.2, z, error);
    EXPECT_NEAR(quantiles.y[k], z, error);
    EXPECT_NEAR((quantiles.yaw[k] - 7.0) / 0.01, z, error);
  }
}

TEST(ParticleCloud, absurdStepsLeaveFiniteParticles) {
  OdometryConfiguration configuration = particleConfiguration(cycab(), AxleSelection::kBoth, 300);
  OdometryEstimator estimator(configuration);
  for (const double travel : {1e3, 1e6, 1e12, 1e25, 0.02}) {
    estimator.step(consistentReadings(configuration.vehicle, travel, slaved(configuration.vehicle, 0.3)),
                   durationFromSeconds(0.02));
    EXPECT_TRUE(estimator.estimate().pose_covariance.allFinite()) << travel;
    EXPECT_TRUE(estimator.estimate().pose.isFinite()) << travel;
  }
}

}  // namespace
}  // namespace bs_car_odometry
