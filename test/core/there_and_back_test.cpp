// From a twist to the wheels and back, over a grid of speed and both steering angles, for four geometries.
#include "support/matchers.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/axle_odometry.hpp"
#include "bs_car_odometry/core/wheel_fit.hpp"

namespace bs_car_odometry {
namespace {

using namespace test_support;

constexpr double kInterval = 0.02;  // s

// Rounding alone: travels of at most some 0.1 m, condition of model (B) and of the fit below 1e4.
constexpr double kTolerance = 1e-12;

class ThereAndBack : public testing::TestWithParam<Vehicle> {
 protected:
  template <typename Check>
  void forEachDrive(const Check& check) const {
    const Vehicle vehicle = withMeasuredRear(GetParam());
    for (const double speed : {-3.0, -1.0, -1e-3, 1e-3, 0.5, 3.0})
      for (const double front : {-0.5, -0.2, -1e-6, 0.0, 0.1, 0.5})
        for (const double rear : {-0.5, -0.1, 0.0, 1e-6, 0.3, 0.5})
          check(vehicle, consistentReadings(vehicle, speed * kInterval, {front, rear}),
                Eigen::Vector3d(bodyTwist(vehicle, speed * kInterval, {front, rear})));
  }
};

TEST_P(ThereAndBack, OneAxle) {
  for (const Axle axle : kAllAxles)
    forEachDrive([axle](const Vehicle& vehicle, const StepReadings& readings, const Eigen::Vector3d& moved) {
      const AxleOdometry odometry(vehicle, NoiseModel(), OdometryOptions(), axle);
      EXPECT_TRUE(matrixNear(odometry.increment(readings).motion, moved, kTolerance))
          << name(axle) << " angles " << readings.end.front << " " << readings.end.rear;
    });
}

TEST_P(ThereAndBack, AllWheels) {
  forEachDrive([](const Vehicle& vehicle, const StepReadings& readings, const Eigen::Vector3d& moved) {
    const BodyIncrement increment = WheelFit(vehicle, NoiseModel()).increment(readings);
    EXPECT_TRUE(matrixNear(increment.motion, moved, kTolerance))
        << "angles " << readings.end.front << " " << readings.end.rear;
    EXPECT_LT(increment.residuals.chi_square, 1e-12);
    EXPECT_EQ(increment.residuals.degrees_of_freedom, 3);
  });
}

TEST_P(ThereAndBack, DirectionOfAWheelToAngleOfItsAxle) {
  forEachDrive([](const Vehicle& vehicle, const StepReadings& readings, const Eigen::Vector3d&) {
    for (const Wheel wheel : kAllWheels) {
      const Axle axle = axleOf(wheel);
      const double other = readings.end[axle == Axle::kFront ? Axle::kRear : Axle::kFront];
      const double direction = wheelDirection(vehicle, wheel, readings.end);
      EXPECT_NEAR(axleAngle(vehicle, wheel, direction, other), readings.end[axle], kTolerance) << name(wheel);
    }
  });
}

/// Turning wheels of an axle with a hub offset roll by themselves (H): the car stands and the steering moves.
TEST_P(ThereAndBack, SteeringWhileStanding) {
  const Vehicle vehicle = withMeasuredRear(GetParam());
  StepReadings readings;
  readings.begin = {0.1, -0.1};
  readings.end = {0.102, -0.103};
  PerWheel<double> turns;
  for (const Wheel wheel : kAllWheels)
    turns[wheel] =
        wheelDirection(vehicle, wheel, readings.end) - wheelDirection(vehicle, wheel, readings.begin);
  readings.travel = wheelSpeeds(vehicle, Eigen::Vector3d::Zero(), readings.mean(), turns);
  EXPECT_TRUE(matrixNear(WheelFit(vehicle, NoiseModel()).increment(readings).motion, Eigen::Vector3d::Zero(),
                         kTolerance));
}

INSTANTIATE_TEST_SUITE_P(FourGeometries, ThereAndBack, testing::ValuesIn(fourGeometries()),
                         [](const auto& vehicle) { return vehicle.param.name; });

/// (H) in motion: the directions of both axles turn while the car drives.
TEST(ThereAndBackWithHub, SteeringWhileDriving) {
  const Vehicle vehicle = withMeasuredRear(unequalCar());
  StepReadings readings;
  readings.begin = {0.2, -0.1};
  readings.end = {0.21, -0.104};
  PerWheel<double> turns;
  for (const Wheel wheel : kAllWheels)
    turns[wheel] =
        wheelDirection(vehicle, wheel, readings.end) - wheelDirection(vehicle, wheel, readings.begin);
  const Eigen::Vector3d twist = bodyTwist(vehicle, 0.05, readings.mean());
  readings.travel = wheelSpeeds(vehicle, twist, readings.mean(), turns);

  EXPECT_TRUE(matrixNear(WheelFit(vehicle, NoiseModel()).increment(readings).motion, twist, kTolerance));
  for (const Axle axle : kAllAxles) {
    const AxleOdometry odometry(vehicle, NoiseModel(), OdometryOptions(), axle);
    const double heading = odometry.axleMotion(readings).heading;
    EXPECT_NEAR(heading, twist.z(), kTolerance) << name(axle);
  }
}

}  // namespace
}  // namespace bs_car_odometry
