// Motion between two laser poses: its derivatives, its parts, and what the wheels say among each other.

#include "calibration_drive.hpp"

#include "bs_car_odometry/calibration/motion_model.hpp"
#include "bs_car_odometry/calibration/odometry_for_calibration.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <vector>

namespace bs_car_odometry::calibration {
namespace {

/// A bend, wheels and angles as if every parameter were off a little.
MeasuredStep bend(double share = 1.0) {
  MeasuredStep step;
  step.span = {timeFromNanoseconds(1000000000), timeFromNanoseconds(1020000000)};
  step.readings.travel = {{0.045 * share, 0.062 * share, 0.046 * share, 0.061 * share}};
  step.readings.begin = {0.21, -0.19};
  step.readings.end = {0.23, -0.21};
  return step;
}

struct Case {
  std::string name;
  AxleSelection axles;
  AxleGeometry geometry;
  RearSteering::Source source;
};

Parameters parametersOf(const Case& tested) {
  Parameters parameters = testParameters();
  parameters.odometry.axles = tested.axles;
  parameters.vehicle.axle_geometry = tested.geometry;
  parameters.vehicle.rear_steering.source = tested.source;
  parameters.vehicle.rear_steering.coefficients = {0.001, -0.9, 0.1};
  parameters.vehicle.steering = {{1.1, 0.01}, {0.95, -0.02}};
  return parameters;
}

/// Steps of a car that is what its configuration says, with readings as fine as numbers are.
std::vector<MeasuredStep> exactSteps(Parameters parameters, const Vehicle& car, double duration) {
  parameters.vehicle.metres_per_tick = {{1e-9, 1e-9, 1e-9, 1e-9}};
  parameters.vehicle.counter_bits = 0;
  Vehicle truth = car;
  truth.metres_per_tick = parameters.vehicle.metres_per_tick;
  truth.counter_bits = 0;
  laboratory::DriveSettings settings;
  settings.scenario = "slalom_eight";
  settings.rate = 50.0;
  settings.duration = duration;
  OdometryPipeline pipeline(toConfiguration(odometryForCalibration(parameters)));
  std::vector<MeasuredStep> steps;
  for (const laboratory::Sample& sample : laboratory::record(truth, settings)) {
    const OdometryUpdate update = laboratory::step(pipeline, sample);
    if (update.step) steps.push_back(*update.step);
  }
  return steps;
}

MotionSegment drivenAt(const Parameters& parameters, const std::vector<MeasuredStep>& steps,
                       const ParameterVector& values) {
  MotionModel model(parameters);
  model.setValues(values);
  MotionSegment segment;
  for (const MeasuredStep& step : steps) model.extend(step, segment);
  return segment;
}

class Derivatives : public ::testing::TestWithParam<Case> {};

/// Against central differences, over 3 m of a slalom. The derivative by an angle is taken at the middle of
/// each step, which leaves the second order of its change there, 1e-4; that of all wheels leaves out what
/// moves with the residuals, which are nothing but the change of the wheels' directions within a step.
TEST_P(Derivatives, ofTheMotionByEveryParameter) {
  constexpr double kDelta = 1e-5;
  constexpr double kTolerance = 1e-3;
  const Parameters parameters = parametersOf(GetParam());
  const std::vector<MeasuredStep> steps = exactSteps(parameters, parameters.vehicle, 3.0);
  const ParameterVector values = valuesOf(parameters);
  const MotionSegment segment = drivenAt(parameters, steps, values);
  for (std::size_t k = 0; k < kMotionCount; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const ParameterVector delta = kDelta * ParameterVector::Unit(i);
    const Eigen::Vector3d numerical = (drivenAt(parameters, steps, values + delta).motion.vector() -
                                       drivenAt(parameters, steps, values - delta).motion.vector()) /
                                      (2.0 * kDelta);
    EXPECT_LT((segment.J.col(i) - numerical).norm(), kTolerance * std::max(numerical.norm(), 1.0))
        << parameterName(k) << "\n"
        << segment.J.col(i).transpose() << "\n"
        << numerical.transpose();
  }
}

/// Rounding alone is between the two: 150 steps, poses of some metres.
TEST_P(Derivatives, areOfTheMotionThatMovesAPose) {
  constexpr double kRounding = 1e-12;
  const Parameters parameters = parametersOf(GetParam());
  const std::vector<MeasuredStep> steps = exactSteps(parameters, parameters.vehicle, 3.0);
  const ParameterVector values = 1.02 * valuesOf(parameters);
  MotionModel model(parameters);
  model.setValues(values);
  Pose2 pose;
  double distance = 0.0;
  for (const MeasuredStep& step : steps) distance += model.move(step, pose);
  const MotionSegment segment = drivenAt(parameters, steps, values);
  EXPECT_LT((pose.vector() - segment.motion.vector()).norm(), kRounding);
  EXPECT_NEAR(distance, segment.distance, kRounding);
}

using Source = RearSteering::Source;
INSTANTIATE_TEST_SUITE_P(
    Models, Derivatives,
    ::testing::Values(
        Case{"rearPivot", AxleSelection::kRear, AxleGeometry::kPivot, Source::kPolynomial},
        Case{"frontPivotMeasured", AxleSelection::kFront, AxleGeometry::kPivot, Source::kMeasured},
        Case{"rearAckermann", AxleSelection::kRear, AxleGeometry::kAckermann, Source::kPolynomial},
        Case{"rearAckermannMeasured", AxleSelection::kRear, AxleGeometry::kAckermann, Source::kMeasured},
        Case{"both", AxleSelection::kBoth, AxleGeometry::kAckermann, Source::kPolynomial},
        Case{"bothMeasured", AxleSelection::kBoth, AxleGeometry::kAckermann, Source::kMeasured}),
    [](const auto& tested) { return tested.param.name; });

/// Twelve digits: with one axle the parts differ from the whole only by rounding when the steering does not
/// move; the weights of a fit depend a little on the length of a step.
TEST(Split, partsMakeTheWhole) {
  Parameters parameters = testParameters();
  parameters.odometry.axles = AxleSelection::kRear;
  MeasuredStep step = bend();
  step.readings.end = step.readings.begin;
  const auto [before, after] = split(step, step.span.begin + std::chrono::milliseconds(7));
  EXPECT_EQ(before.span.end, after.span.begin);
  EXPECT_EQ(after.span.end, step.span.end);
  const MotionModel model(parameters);
  MotionSegment whole;
  MotionSegment parts;
  model.extend(step, whole);
  model.extend(before, parts);
  model.extend(after, parts);
  EXPECT_LT((whole.motion.vector() - parts.motion.vector()).norm(), 1e-12);
  EXPECT_NEAR(whole.distance, parts.distance, 1e-12);
  // The position's noise differs by where in the step the heading's noise is thought to enter.
  EXPECT_NEAR(whole.noise(2, 2), parts.noise(2, 2), 1e-3 * whole.noise(2, 2));
  EXPECT_LT((whole.J - parts.J).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Split, steeringGoesOnFromWhereItIs) {
  const MeasuredStep step = bend();
  const auto [before, after] = split(step, step.span.begin + std::chrono::milliseconds(5));
  EXPECT_NEAR(before.readings.end.front, 0.215, 1e-12);
  EXPECT_EQ(before.readings.end.front, after.readings.begin.front);
  EXPECT_EQ(after.readings.end.rear, -0.21);
}

/// One axle leaves nothing over.
TEST(Evidence, isForAllWheelsOnly) {
  Parameters parameters = testParameters();
  parameters.odometry.axles = AxleSelection::kRear;
  MotionSegment segment;
  MotionModel(parameters).extend(bend(), segment);
  EXPECT_TRUE(segment.evidence.information.isZero(0.0));
}

/// Gains 0.1 % off, exact readings of bends: the gradient is what an error of that size explains, information
/// times error. Within the 0.2 m that are compared the angles bend, which looks like a track 4e-5 wider.
TEST(Evidence, pointsFromWrongGainsToTheTruth) {
  const Parameters parameters = testParameters();
  ParameterVector error = ParameterVector::Zero();
  error.head<systematic::kCount>() << 1e-3, -2e-3, 1.5e-3, 0.0, -1e-3, 0.5e-3, 2e-3, 0.0;
  Vehicle truth = parameters.vehicle;
  setValues(valuesOf(parameters) + error, truth);
  const MotionSegment segment =
      drivenAt(parameters, exactSteps(parameters, truth, 20.0), valuesOf(parameters));
  const Eigen::VectorXd expected = segment.evidence.information * error.head<kMotionCount>();
  EXPECT_LT((segment.evidence.gradient - expected).norm(), 0.05 * expected.norm())
      << segment.evidence.gradient.transpose() << "\n"
      << expected.transpose();
}

/// A step that contradicts itself has a bounded say.
TEST(Evidence, ofASlippingWheelIsBelievedLess) {
  const MotionModel model(testParameters());
  MotionSegment sound;
  MotionSegment slipping;
  MeasuredStep step = bend();
  step.readings.end = step.readings.begin = {0.0, 0.0};
  step.readings.travel = {{0.05, 0.05, 0.05, 0.05}};
  for (int i = 0; i < 4; ++i) model.extend(step, sound);
  step.readings.travel[Wheel::kRearRight] = 0.1;
  for (int i = 0; i < 4; ++i) model.extend(step, slipping);
  EXPECT_LT(slipping.evidence.information(systematic::kFrontLeft, systematic::kFrontLeft),
            0.05 * sound.evidence.information(systematic::kFrontLeft, systematic::kFrontLeft));
}

/// Readings are compared over 0.2 m, which are four of these steps: three, one that cannot be trusted, and
/// three are not enough.
TEST(Evidence, ofReadingsThatCannotBeTrustedThereIsNone) {
  const MotionModel model(testParameters());
  MeasuredStep sound = bend();
  sound.readings.end = sound.readings.begin;
  MeasuredStep front = sound;
  front.steering_doubt.front = 0.1;
  MeasuredStep rear = sound;
  rear.steering_doubt.rear = 0.1;
  MeasuredStep wheel = sound;
  wheel.readings.left_out[Wheel::kRearLeft] = true;
  const auto informationOf = [&](const MeasuredStep& fourth) {
    MotionSegment segment;
    for (int i = 0; i < 7; ++i) model.extend(i == 3 ? fourth : sound, segment);
    return segment.evidence.information.norm();
  };
  EXPECT_GT(informationOf(sound), 0.0);
  for (const MeasuredStep& doubtful : {front, rear, wheel}) EXPECT_EQ(informationOf(doubtful), 0.0);
}

/// Against the same drive with another angle in the step that is doubted; the difference of two drives leaves
/// a few digits fewer than the angle has.
TEST_P(Derivatives, byAnAngleThatIsDoubtedInOneStep) {
  constexpr double kDelta = 1e-6;
  constexpr double kSigma = 0.05;
  constexpr std::size_t kDoubted = 20;
  Case tested = GetParam();
  tested.source = RearSteering::Source::kMeasured;
  const Parameters parameters = parametersOf(tested);
  const ParameterVector values = valuesOf(parameters);
  const std::vector<MeasuredStep> steps = exactSteps(parameters, parameters.vehicle, 3.0);
  for (const Axle axle : kAllAxles) {
    std::vector<MeasuredStep> doubted = steps;
    doubted[kDoubted].steering_doubt[axle] = kSigma;
    std::vector<MeasuredStep> turned = steps;
    for (SteeringAngles* angles : {&turned[kDoubted].readings.begin, &turned[kDoubted].readings.end})
      (axle == Axle::kFront ? angles->front : angles->rear) += kDelta;
    const Eigen::Vector3d numerical = (drivenAt(parameters, turned, values).motion.vector() -
                                       drivenAt(parameters, steps, values).motion.vector()) /
                                      kDelta;
    const Eigen::Vector3d doubt =
        drivenAt(parameters, doubted, values).doubt.col(axle == Axle::kFront ? 0 : 1);
    EXPECT_LT((doubt - kSigma * numerical).norm(), 1e-2 * kSigma * numerical.norm() + 1e-9)
        << name(axle) << "\n"
        << doubt.transpose() << "\n"
        << kSigma * numerical.transpose();
  }
}

}  // namespace
}  // namespace bs_car_odometry::calibration
