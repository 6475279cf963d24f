// Every derivative against central differences, over angles from 1e-12 to 1 of either sign and zero.
#include "support/matchers.hpp"
#include "support/numerical_derivative.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/axle_odometry.hpp"
#include "bs_car_odometry/core/wheel_fit.hpp"

namespace bs_car_odometry {
namespace {

using namespace test_support;

// Differences with h = 2e-4 round to some 1e-12; model (B) on a wheel that all but stands (the sharpest of
// these curves) has a fifth derivative of up to 1e6, which leaves 5e-17 * 1e6.
constexpr double kDifferenceError = 1e-10;

/// The step of a moving car, so that one unit of any input is one unit of motion.
constexpr double kTravel = 1.0;

struct PairOfTravels {
  double right;
  double left;
};

/// Travels of Ackermann wheels at `alpha` when the axle's middle travels 1 m and the car turns by `heading`.
PairOfTravels ackermannTravels(double alpha, double heading, double track) {
  const auto length = [&](double outward) {
    return std::hypot(std::cos(alpha) * kTravel + outward * 0.5 * track * heading, std::sin(alpha) * kTravel);
  };
  return {length(1.0), length(-1.0)};
}

template <typename Model>
void expectAxleJacobian(const Model& model, const Eigen::Vector4d& inputs) {
  const auto f = [&](const Eigen::Vector4d& x) {
    const AxleMotion motion = model(x);
    return Eigen::Vector2d(motion.travel, motion.heading);
  };
  const Eigen::Matrix<double, 2, 4> J = numericalDerivative<2, 4>(f, inputs);
  EXPECT_TRUE(matrixNear(model(inputs).J, J, kDifferenceError)) << "at " << inputs.transpose();
}

TEST(Jacobians, PivotAxle) {
  for (const double hub_offset : {0.0, 0.07})
    for (const double alpha : signedSweep())
      for (const double change : {0.0, 0.2, -1e-6})
        expectAxleJacobian(
            [&](const Eigen::Vector4d& x) { return pivotAxle(x(0), x(1), x(2), change, x(3), hub_offset); },
            {1.1, 0.9, alpha, 1.2});
}

TEST(Jacobians, UnshortenedAxle) {
  expectAxleJacobian([](const Eigen::Vector4d& x) { return unshortenedAxle(x(0), x(1), x(3)); },
                     {1.1, 0.9, 0.3, 1.2});
}

TEST(Jacobians, AckermannAxleOverTheSteeringAngle) {
  for (const double alpha : signedSweep())
    for (const double sign : {1.0, -1.0}) {
      const PairOfTravels travels = ackermannTravels(alpha, 0.1, 1.2);
      expectAxleJacobian([](const Eigen::Vector4d& x) { return ackermannAxle(x(0), x(1), x(2), x(3)); },
                         {sign * travels.right, sign * travels.left, alpha, 1.2});
    }
}

TEST(Jacobians, AckermannAxleOverTheHeadingIncrement) {
  for (const double heading : signedSweep()) {
    const PairOfTravels travels = ackermannTravels(0.4, 0.5 * heading, 1.2);
    expectAxleJacobian([](const Eigen::Vector4d& x) { return ackermannAxle(x(0), x(1), x(2), x(3)); },
                       {travels.right, travels.left, 0.4, 1.2});
  }
}

TEST(Jacobians, DirectedAxle) {
  for (const double alpha : signedSweep()) {
    const auto f = [&](const Eigen::Vector2d& x) {
      const AxleMotion motion = directedAxle(x(0), x(1), alpha, 0.9 * alpha, 1.1 * alpha, 1.2);
      return Eigen::Vector2d(motion.travel, motion.heading);
    };
    const Eigen::Matrix2d J = numericalDerivative<2, 2>(f, Eigen::Vector2d(1.1, 0.9));
    EXPECT_TRUE(matrixNear(directedAxle(1.1, 0.9, alpha, 0.9 * alpha, 1.1 * alpha, 1.2).J.leftCols<2>(), J,
                           kDifferenceError))
        << alpha;
  }
}

/// Increment of the model made for `vehicle`, with the parameters A moved by `error` and the same raw
/// readings.
template <typename Model>
Eigen::Vector3d motionWithError(Vehicle vehicle, const StepReadings& readings,
                                const Eigen::Matrix<double, systematic::kCount, 1>& error,
                                const Model& model) {
  using namespace systematic;
  StepReadings moved = readings;
  const auto scale = [&](Wheel wheel, double& gain, double change) {
    moved.travel[wheel] *= (gain + change) / gain;
    gain += change;
  };
  scale(Wheel::kFrontRight, vehicle.gains.front.k_r, error(kFrontRight));
  scale(Wheel::kFrontLeft, vehicle.gains.front.k_l, error(kFrontLeft));
  scale(Wheel::kRearRight, vehicle.gains.rear.k_r, error(kRearRight));
  scale(Wheel::kRearLeft, vehicle.gains.rear.k_l, error(kRearLeft));
  vehicle.gains.front.k_b += error(kFrontTrack);
  vehicle.gains.rear.k_b += error(kRearTrack);
  const bool measured = vehicle.rear_steering.source == RearSteering::Source::kMeasured;
  for (SteeringAngles* angles : {&moved.begin, &moved.end}) {
    angles->front += error(kFrontOffset);
    angles->rear = measured ? angles->rear + error(kRearOffset) : vehicle.rear_steering.angle(angles->front);
  }
  return model(vehicle, moved).motion;
}

template <typename Model>
void expectSystematicJacobian(const Vehicle& vehicle, const StepReadings& readings, double tolerance,
                              const Model& model) {
  using Parameters = Eigen::Matrix<double, systematic::kCount, 1>;
  const auto f = [&](const Parameters& error) { return motionWithError(vehicle, readings, error, model); };
  const SystematicSensitivity J =
      numericalDerivative<3, systematic::kCount>(f, Parameters(Parameters::Zero()));
  EXPECT_TRUE(matrixNear(model(vehicle, readings).J_motion_systematic, J, tolerance))
      << vehicle.name << " angles " << readings.begin.front << " " << readings.begin.rear << " to "
      << readings.end.front << " " << readings.end.rear;
}

/// One-axle odometry; `motion` and `axle` chosen by the caller.
auto axleModel(Axle axle, Motion motion = Motion::kExact) {
  return [=](const Vehicle& vehicle, const StepReadings& readings) {
    OdometryOptions options;
    options.motion = motion;
    return AxleOdometry(vehicle, NoiseModel(), options, axle).increment(readings);
  };
}

/// Four wheels, noise as default but without the systematic part.
BodyIncrement fitModel(const Vehicle& vehicle, const StepReadings& readings) {
  return WheelFit(vehicle, NoiseModel()).increment(readings);
}

Vehicle withGains(Vehicle vehicle) {
  vehicle.gains.front = {1.02, 0.99, 1.03};
  vehicle.gains.rear = {0.98, 1.01, 0.97};
  return vehicle;
}

/// Within what every wheel still rolls forward; unequalCar turns on a circle of 0.9 m at 0.7 rad.
constexpr double kLargestAngle = 0.7;

TEST(Jacobians, AxleOdometryOverTheSteeringAngle) {
  for (const Vehicle& plain : fourGeometries()) {
    const Vehicle vehicle = withGains(plain);
    for (const double angle : signedSweep()) {
      const StepReadings readings =
          consistentReadings(vehicle, kTravel, slaved(vehicle, kLargestAngle * angle));
      for (const Axle axle : kAllAxles)
        expectSystematicJacobian(vehicle, readings, kDifferenceError, axleModel(axle));
    }
  }
}

TEST(Jacobians, AxleOdometryWithTheRearAngleMeasured) {
  for (const double angle : signedSweep()) {
    const Vehicle vehicle = withMeasuredRear(withGains(unequalCar()));
    const StepReadings readings = consistentReadings(vehicle, kTravel, {0.3, kLargestAngle * angle});
    for (const Axle axle : kAllAxles)
      expectSystematicJacobian(vehicle, readings, kDifferenceError, axleModel(axle));
  }
}

/// The steering moves within the step: the chord of (M-arc) bends by the change of the angle. No hub offset,
/// whose turning directions enter the derivatives only through their mean.
TEST(Jacobians, AxleOdometryOverTheSteeringChange) {
  for (const Vehicle& vehicle : {cycab(), pivotCar()})
    for (const double change : signedSweep()) {
      StepReadings readings = consistentReadings(vehicle, kTravel, slaved(vehicle, 0.2));
      readings.end = slaved(vehicle, 0.2 + 0.5 * change);
      for (const Axle axle : kAllAxles)
        expectSystematicJacobian(vehicle, readings, kDifferenceError, axleModel(axle));
    }
}

TEST(Jacobians, AxleOdometryPivotWithHubOverTheSteeringChange) {
  Vehicle vehicle = pivotCar();
  vehicle.hub_offset = {0.06, 0.04};
  for (const double change : signedSweep()) {
    StepReadings readings = consistentReadings(vehicle, kTravel, slaved(vehicle, 0.2));
    readings.end = slaved(vehicle, 0.2 + 0.5 * change);
    for (const Axle axle : kAllAxles)
      expectSystematicJacobian(vehicle, readings, kDifferenceError, axleModel(axle));
  }
}

TEST(Jacobians, AxleOdometryOverTheHeadingIncrement) {
  for (const Vehicle& vehicle : fourGeometries())
    for (const double heading : signedSweep()) {
      const SteeringAngles steering = slaved(vehicle, 0.2);
      StepReadings readings = consistentReadings(vehicle, kTravel, steering);
      readings.travel[Wheel::kFrontRight] += 0.3 * heading;
      readings.travel[Wheel::kRearRight] += 0.3 * heading;
      for (const Axle axle : kAllAxles)
        expectSystematicJacobian(vehicle, readings, kDifferenceError, axleModel(axle));
    }
}

TEST(Jacobians, AxleOdometryOfThePaper) {
  for (const double angle : signedSweep()) {
    const Vehicle vehicle = withMeasuredRear(withGains(pivotCar()));
    StepReadings readings =
        consistentReadings(vehicle, kTravel, {kLargestAngle * angle, -kLargestAngle * angle});
    readings.begin = {0.1, 0.2};  // not used by (2)
    for (const Axle axle : kAllAxles)
      expectSystematicJacobian(vehicle, readings, kDifferenceError, axleModel(axle, Motion::kPaper));
  }
}

/// Wheel noise shows J(S_r), J(S_l) once more, steering noise J(alpha).
TEST(Jacobians, AxleOdometryCovarianceIsThatOfItsJacobian) {
  const Vehicle vehicle = withMeasuredRear(withGains(unequalCar()));
  const StepReadings readings = consistentReadings(vehicle, kTravel, {0.3, -0.2});
  NoiseModel noise = noNoise();
  noise.wheel = 0.005;
  noise.steering = {0.003, 0.1};
  const AxleOdometry odometry(vehicle, noise, OdometryOptions(), Axle::kRear);
  const BodyIncrement increment = odometry.increment(readings);
  const double right = readings.travel[Wheel::kRearRight];
  const double left = readings.travel[Wheel::kRearLeft];
  const SystematicSensitivity& J = increment.J_motion_systematic;
  const Eigen::Vector3d J_right = J.col(systematic::kRearRight) * vehicle.gains.rear.k_r / right;
  const Eigen::Vector3d J_left = J.col(systematic::kRearLeft) * vehicle.gains.rear.k_l / left;
  const Eigen::Vector3d J_alpha = J.col(systematic::kRearOffset);
  const double steering_variance = 0.003 * 0.003 * 0.1 / (0.5 * (right + left));
  const Eigen::Matrix3d expected =
      0.005 * 0.005 * (right * J_right * J_right.transpose() + left * J_left * J_left.transpose()) +
      steering_variance * J_alpha * J_alpha.transpose();
  EXPECT_TRUE(matrixRelativelyNear(increment.path_covariance, expected, 1e-12));
}

// The weights move with the readings too, at second order on consistent ones: differences see h^4 of it. A
// fit adds the cancellation of a 3x3 inverse, condition some 1e4, to the rounding: 1e-16 * 1e4 / 2e-4.
constexpr double kFitDifferenceError = 1e-8;

TEST(Jacobians, WheelFitOverTheSteeringAngle) {
  for (const Vehicle& plain : fourGeometries()) {
    const Vehicle vehicle = withGains(plain);
    for (const double angle : signedSweep())
      expectSystematicJacobian(vehicle, consistentReadings(vehicle, kTravel, slaved(vehicle, 0.5 * angle)),
                               kFitDifferenceError, fitModel);
  }
}

TEST(Jacobians, WheelFitWithTheRearAngleMeasured) {
  for (const Vehicle& plain : fourGeometries()) {
    const Vehicle vehicle = withMeasuredRear(withGains(plain));
    for (const double angle : signedSweep())
      expectSystematicJacobian(vehicle, consistentReadings(vehicle, kTravel, {0.2, 0.5 * angle}),
                               kFitDifferenceError, fitModel);
  }
}

TEST(Jacobians, WheelFitInReverseAndWithAMissingWheel) {
  Vehicle vehicle = withGains(unequalCar());
  vehicle.metres_per_tick[Wheel::kFrontRight] = 0.0;
  for (const double angle : signedSweep()) {
    StepReadings readings = consistentReadings(vehicle, -kTravel, slaved(vehicle, 0.5 * angle));
    readings.travel[Wheel::kFrontRight] = 0.0;
    expectSystematicJacobian(vehicle, readings, kFitDifferenceError, fitModel);
  }
}

Eigen::Vector3d poseAfter(const Eigen::Vector3d& pose, const Eigen::Vector3d& motion) {
  return advance({pose.x(), pose.y(), pose.z()}, motion).pose.vector();
}

TEST(Jacobians, AdvanceOverTheHeadingIncrement) {
  for (const double heading : signedSweep())
    for (const double yaw : {0.0, 0.7, -3.0}) {
      const Eigen::Vector3d pose(1.0, 2.0, yaw);
      const Eigen::Vector3d motion(0.9, -0.2, heading);
      const PoseStep step = advance({pose.x(), pose.y(), pose.z()}, motion);
      const auto of_motion = [&](const Eigen::Vector3d& t) { return poseAfter(pose, t); };
      const auto of_pose = [&](const Eigen::Vector3d& p) { return poseAfter(p, motion); };
      EXPECT_TRUE(
          matrixNear(step.J_pose_motion(), numericalDerivative<3, 3>(of_motion, motion), kDifferenceError));
      EXPECT_TRUE(matrixNear(step.J_pose_pose(), numericalDerivative<3, 3>(of_pose, pose), kDifferenceError));
    }
}

/// sinc as a power series in extended precision; at |u| <= 2 forty terms leave nothing.
long double sincSeries(long double u, bool derivative) {
  long double term = 1.0L;
  long double sum = derivative ? 0.0L : 1.0L;
  for (int n = 1; n < 40; ++n) {
    term *= -u * u / (2.0L * n * (2.0L * n + 1.0L));
    sum += derivative ? 2.0L * n * term / u : term;
  }
  return sum;
}

/// Rounding of the result and of a few operations: some units of 1.1e-16; cancellation at 0.3, where the
/// formula takes over, leaves u^-2 = 11 times as much for the derivative.
TEST(Jacobians, SincToTheLastDigits) {
  for (const double u : signedSweep()) {
    if (u == 0.0) continue;
    for (const double scale : {1.0, 0.29, 0.31, 2.0}) {
      const double at = scale * u;
      EXPECT_TRUE(relativelyNear(sinc(at), static_cast<double>(sincSeries(at, false)), 5e-16)) << at;
      EXPECT_TRUE(relativelyNear(sincDerivative(at), static_cast<double>(sincSeries(at, true)), 1e-14)) << at;
    }
  }
  EXPECT_EQ(sinc(0.0), 1.0);
  EXPECT_EQ(sincDerivative(0.0), 0.0);
}

}  // namespace
}  // namespace bs_car_odometry
