// Drives whose end is known in closed form.
#include "support/figure.hpp"
#include "support/matchers.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/odometry_estimator.hpp"

namespace bs_car_odometry {
namespace {

using namespace test_support;

// Some hundred steps of rounding error on positions of some metres.
constexpr double kTolerance = 1e-12;

OdometryEstimator makeEstimator(const Vehicle& vehicle, AxleSelection axles = AxleSelection::kBoth) {
  OdometryConfiguration configuration;
  configuration.vehicle = vehicle;
  configuration.options.axles = axles;
  return OdometryEstimator(configuration);
}

void drive(OdometryEstimator& estimator, const StepReadings& readings, int steps) {
  for (int i = 0; i < steps; ++i) ASSERT_TRUE(estimator.step(readings, durationFromSeconds(0.02)));
}

void expectPose(const OdometryEstimator& estimator, const Eigen::Vector3d& expected,
                double tolerance = kTolerance) {
  EXPECT_TRUE(matrixNear(estimator.estimate().pose.vector(), expected, tolerance));
}

constexpr std::array<AxleSelection, 3> kSelections{AxleSelection::kBoth, AxleSelection::kFront,
                                                   AxleSelection::kRear};

TEST(ClosedForms, Straight) {
  for (const Vehicle& vehicle : {cycab(), ordinaryCar(), pivotCar()})
    for (const AxleSelection axles : kSelections) {
      OdometryEstimator estimator = makeEstimator(vehicle, axles);
      drive(estimator, consistentReadings(vehicle, 0.02, {}), 100);
      expectPose(estimator, {2.0, 0.0, 0.0});
    }
}

/// f = +phi: the car moves sideways and does not turn.
TEST(ClosedForms, PureCrab) {
  Vehicle vehicle = cycab();
  vehicle.rear_steering.coefficients = {0.0, 1.0};
  const double along = 2.0;
  for (const AxleSelection axles : kSelections) {
    OdometryEstimator estimator = makeEstimator(vehicle, axles);
    drive(estimator, consistentReadings(vehicle, along / 100, slaved(vehicle, 0.3)), 100);
    expectPose(estimator, {along, along * std::tan(0.3), 0.0});
    EXPECT_NEAR(estimator.estimate().twist.y(), std::tan(0.3), kTolerance);
  }
}

/// Cycab at phi = 0.3: base_link rolls without side slip on a circle of radius L/(2 tan(phi)).
TEST(ClosedForms, QuarterCircle) {
  const Vehicle vehicle = cycab();
  const double radius = 1.2 / (2.0 * std::tan(0.3));
  for (const AxleSelection axles : kSelections) {
    OdometryEstimator estimator = makeEstimator(vehicle, axles);
    drive(estimator, consistentReadings(vehicle, radius * M_PI_2 / 50, slaved(vehicle, 0.3)), 50);
    expectPose(estimator, {radius, radius, M_PI_2});
  }
}

TEST(ClosedForms, CounterSteer) {
  const Vehicle vehicle = cycab();
  const double radius = 1.2 / (2.0 * std::tan(0.3));
  const double step = radius * M_PI_2 / 50;
  for (const AxleSelection axles : kSelections) {
    OdometryEstimator estimator = makeEstimator(vehicle, axles);
    drive(estimator, consistentReadings(vehicle, step, slaved(vehicle, 0.3)), 50);
    drive(estimator, consistentReadings(vehicle, step, slaved(vehicle, -0.3)), 50);
    expectPose(estimator, {2.0 * radius, 2.0 * radius, 0.0});
  }
}

TEST(ClosedForms, ReverseComesBack) {
  for (const Vehicle& vehicle : fourGeometries())
    for (const AxleSelection axles : kSelections) {
      OdometryEstimator estimator = makeEstimator(vehicle, axles);
      drive(estimator, consistentReadings(vehicle, 0.05, slaved(vehicle, 0.4)), 100);
      EXPECT_GT(estimator.estimate().pose.position().norm(), 0.1);
      drive(estimator, consistentReadings(vehicle, -0.05, slaved(vehicle, 0.4)), 100);
      expectPose(estimator, Eigen::Vector3d::Zero());
    }
}

TEST(ClosedForms, StandstillChangesNothingAtAll) {
  for (const Vehicle& vehicle : fourGeometries())
    for (const AxleSelection axles : kSelections) {
      OdometryEstimator estimator = makeEstimator(vehicle, axles);
      drive(estimator, consistentReadings(vehicle, 0.05, slaved(vehicle, 0.3)), 20);
      const OdometryEstimate before = estimator.estimate();
      const FirstOrderCovariance covariance = firstOrder(estimator);
      StepReadings standing;
      standing.begin = standing.end = slaved(vehicle, 0.3);
      drive(estimator, standing, 1000);
      EXPECT_EQ(estimator.estimate().pose.vector(), before.pose.vector());
      EXPECT_EQ(estimator.estimate().pose_covariance, before.pose_covariance);
      EXPECT_EQ(firstOrder(estimator).sensitivity(), covariance.sensitivity());
      EXPECT_EQ(estimator.estimate().twist, Eigen::Vector3d::Zero());
    }
}

/// A differential robot is the axle of a car at alpha = 0.
TEST(ClosedForms, DifferentialRobot) {
  Vehicle vehicle = cycab();
  vehicle.base_link_x = 0.0;
  vehicle.rear_steering.coefficients = {0.0};
  vehicle.metres_per_tick[Wheel::kFrontLeft] = vehicle.metres_per_tick[Wheel::kFrontRight] = 0.0;
  OdometryEstimator estimator = makeEstimator(vehicle, AxleSelection::kRear);
  const double outer = (2.0 + 0.6) * M_PI_2 / 100;
  const double inner = (2.0 - 0.6) * M_PI_2 / 100;
  StepReadings readings;
  readings.travel[Wheel::kRearRight] = outer;
  readings.travel[Wheel::kRearLeft] = inner;
  drive(estimator, readings, 100);
  expectPose(estimator, {2.0, 2.0, M_PI_2});

  OdometryEstimator spinning = makeEstimator(vehicle, AxleSelection::kRear);
  readings.travel[Wheel::kRearRight] = 0.6 * M_PI_2 / 100;
  readings.travel[Wheel::kRearLeft] = -0.6 * M_PI_2 / 100;
  drive(spinning, readings, 100);
  expectPose(spinning, {0.0, 0.0, M_PI_2});
}

/// Encoders on one axle alone; the fit works with what there is.
TEST(ClosedForms, CarWithTwoWheels) {
  for (const Axle blind : kAllAxles) {
    Vehicle vehicle = cycab();
    for (const Wheel wheel : {leftWheel(blind), rightWheel(blind)}) vehicle.metres_per_tick[wheel] = 0.0;
    OdometryEstimator estimator = makeEstimator(vehicle);
    const double radius = 1.2 / (2.0 * std::tan(0.3));
    StepReadings readings = consistentReadings(vehicle, radius * M_PI_2 / 50, slaved(vehicle, 0.3));
    for (const Wheel wheel : {leftWheel(blind), rightWheel(blind)}) readings.travel[wheel] = 0.0;
    drive(estimator, readings, 50);
    expectPose(estimator, {radius, radius, M_PI_2});
    EXPECT_EQ(estimator.residuals().degrees_of_freedom, 1);
    EXPECT_EQ(estimator.residuals().wheel[leftWheel(blind)], 0.0);
    EXPECT_TRUE(isCovariance(estimator.estimate().pose_covariance));
  }
}

/// A thousand turns: position within a micrometre, and the heading keeps counting.
TEST(ClosedForms, O6_ThousandTurns) {
  const Vehicle vehicle = cycab();
  const double radius = 1.2 / (2.0 * std::tan(0.3));
  OdometryEstimator estimator = makeEstimator(vehicle);
  drive(estimator, consistentReadings(vehicle, radius * 2.0 * M_PI / 200, slaved(vehicle, 0.3)), 200 * 1000);
  // 2e5 additions of 0.03 rad round to 1e-13 each at 6e3 rad: 1e-8 rad at worst.
  expectPose(estimator, {0.0, 0.0, 2000.0 * M_PI}, 1e-6);
  EXPECT_TRUE(isCovariance(estimator.estimate().pose_covariance));
}

/// The same path from a start far away, and the same covariance.
TEST(ClosedForms, O7_FarOrigin) {
  const Vehicle vehicle = cycab();
  OdometryEstimator near = makeEstimator(vehicle);
  OdometryEstimator far = makeEstimator(vehicle);
  far.setPose({1e7, -1e7, 0.0}, Eigen::Matrix3d::Zero());
  for (OdometryEstimator* estimator : {&near, &far})
    for (const double phi : {0.2, -0.3, 0.1})
      drive(*estimator, consistentReadings(vehicle, 0.05, slaved(vehicle, phi)), 100);
  // A position of 1e7 m is rounded to 1e-9 m, three hundred times.
  const Eigen::Vector3d moved = far.estimate().pose.vector() - Eigen::Vector3d(1e7, -1e7, 0.0);
  EXPECT_TRUE(matrixNear(moved, near.estimate().pose.vector(), 1e-6));
  recordFigure("the path of 15 m at 1e7 m within %.0e m",
               roundedUp((moved - near.estimate().pose.vector()).cwiseAbs().maxCoeff()));
  EXPECT_TRUE(matrixRelativelyNear(far.estimate().pose_covariance, near.estimate().pose_covariance, 1e-12));
}

}  // namespace
}  // namespace bs_car_odometry
