// One prediction and one update of the joint filter against reference values (docs/model.md, 9: T10), and the
// bound of the package's own model against the one of the reference run.
#include "bs_car_odometry/calibration/drive_bound.hpp"
#include "bs_car_odometry/calibration/joint_filter.hpp"

#include "reference_run.hpp"
#include "support/matchers.hpp"

namespace bs_car_odometry::calibration {
namespace {

using systematic::kRearRight;
using test_support::matrixRelativelyNear;
using test_support::relativelyNear;

constexpr double kPrior = 0.02;

/// (M-1) with model A on the rear axle of a Cycab, base_link in its middle.
Parameters paperCar(double correlation_length) {
  Parameters parameters;
  parameters.vehicle.wheelbase = reference::kWheelbase;
  parameters.vehicle.track = {reference::kTrack, reference::kTrack};
  for (const Wheel wheel : kAllWheels) parameters.vehicle.metres_per_tick[wheel] = 1e-4;
  parameters.vehicle.gains.rear = {reference::kRightGain, reference::kLeftGain, reference::kTrackGain};
  parameters.odometry.axles = AxleSelection::kRear;
  parameters.odometry.motion = Motion::kPaper;
  parameters.noise.wheel = reference::kWheel;
  parameters.noise.steering.angle = reference::kAngle;
  parameters.noise.steering.correlation_length = correlation_length;
  parameters.noise.lateral = 0.0;
  parameters.noise.rear_law = 0.0;
  parameters.calibration.prior.k_r = parameters.calibration.prior.k_l = parameters.calibration.prior.k_b =
      kPrior;
  return parameters;
}

MeasuredStep stepOf(double right, double left, double alpha) {
  MeasuredStep step;
  step.span = {timeFromNanoseconds(1000000000), timeFromNanoseconds(1020000000)};
  step.readings.travel[Wheel::kRearRight] = right;
  step.readings.travel[Wheel::kRearLeft] = left;
  step.readings.begin = step.readings.end = {-alpha, alpha};
  return step;
}

LaserPose laserAt(const Eigen::Vector3d& pose) {
  return {timeFromNanoseconds(1020000000), {pose.x(), pose.y(), pose.z()}, reference::laserCovariance()};
}

/// With the path of this step as correlation length the angle's variance is std^2 in the step.
JointFilter filterAfterTheStep() {
  const double right = reference::kRightGain * 0.55;
  const double left = reference::kLeftGain * 0.45;
  JointFilter filter(paperCar(0.5 * (right + left)), false);
  filter.begin(laserAt({1.0, 2.0, 0.7}));
  filter.move(stepOf(right, left, -0.3));
  return filter;
}

const Eigen::Vector3d kPredictedPose(1.45338883658, 2.21840129433, 0.797815380241);

/// Diagonal of the covariance of pose and rear gains.
Eigen::Matrix<double, 6, 1> variances(const FilterEstimate& estimate) {
  Eigen::Matrix<double, 6, 1> result;
  result << estimate.pose_covariance.diagonal(), estimate.covariance.diagonal().segment<3>(kRearRight);
  return result;
}

TEST(JointFilter, T10Prediction) {
  const FilterEstimate estimate = filterAfterTheStep().estimate();
  EXPECT_TRUE(matrixRelativelyNear(estimate.pose.vector(), kPredictedPose, 1e-9));
  Eigen::Matrix<double, 6, 1> expected;
  expected << 0.000446116121361, 0.000429760923507, 0.000191540399391, 4e-4, 4e-4, 4e-4;
  EXPECT_TRUE(matrixRelativelyNear(variances(estimate), expected, 1e-9));
  // Columns of the gains, times their variance: the covariance of pose and gains after one step.
  Eigen::Matrix3d columns;
  columns << 0.196889163447, 0.244323623273, 0.010370391092,  //
      0.224936401594, 0.0112528943674, -0.0215283502171,      //
      0.465787524956, -0.381098884055, -0.0949663885833;
  EXPECT_TRUE(
      matrixRelativelyNear(estimate.cross.middleCols<3>(kRearRight) / (kPrior * kPrior), columns, 1e-9));
}

TEST(JointFilter, T10Update) {
  JointFilter filter = filterAfterTheStep();
  const Innovation innovation =
      filter.update(laserAt(kPredictedPose + Eigen::Vector3d(0.03, -0.01, 0.004)), 0.0);
  EXPECT_TRUE(relativelyNear(innovation.nis, 1.31672926623, 1e-9));
  EXPECT_EQ(innovation.weight, 1.0);
  const FilterEstimate estimate = filter.estimate();
  EXPECT_TRUE(matrixRelativelyNear(estimate.pose.vector(),
                                   Eigen::Vector3d(1.46900633442, 2.21416968842, 0.801228931791), 1e-9));
  EXPECT_TRUE(matrixRelativelyNear(estimate.values.segment<3>(kRearRight),
                                   Eigen::Vector3d(1.02590480296, 0.989873156315, 1.02938224992), 1e-9));
  Eigen::Matrix<double, 6, 1> expected;
  expected << 0.000210742486061, 0.000203533609372, 2.20596794104e-05, 0.000229277660649, 0.000280333522808,
      0.000393324348786;
  EXPECT_TRUE(matrixRelativelyNear(variances(estimate), expected, 1e-9));
}

/// Bound by MotionModel of a run of the paper's model.
ParameterVector driveBound(const Parameters& parameters, const std::vector<reference::Step>& steps,
                           double prior) {
  DriveBound bound(parameters, parametersToEstimate(parameters), ParameterVector::Constant(prior));
  bound.update(reference::laserCovariance());
  for (const reference::Step& step : steps) {
    bound.move(stepOf(step.right, step.left, step.alpha));
    if (step.laser) bound.update(reference::laserCovariance());
  }
  return bound.deviations();
}

/// The package's angle noise goes by the way and the reference run's by the step: at constant speed they are
/// the same with the way of a step as correlation length. What remains is the run's 10 um of rounding.
TEST(DriveBound, equalsTheReferenceRecursion) {
  const std::vector<reference::Step> steps = reference::drive(reference::slalomEight(), 20.0);
  const Parameters parameters = paperCar(steps.back().distance / static_cast<double>(steps.size()));
  CramerRaoBound expected(Eigen::Vector3d::Constant(kDiffuse));
  const auto fix = [&] {
    expected.update(Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero(), reference::laserCovariance());
  };
  fix();
  for (const reference::Step& step : steps) {
    const reference::Linearised at = reference::linearise(step);
    expected.predict(at.F, at.J, at.Q());
    if (step.laser) fix();
  }
  const ParameterVector bound = driveBound(parameters, steps, kDiffuse);
  EXPECT_TRUE(matrixRelativelyNear(bound.segment<3>(kRearRight), expected.deviations(), 2e-3));
  EXPECT_EQ(bound.head<4>().norm(), 0.0);  // the front axle is not estimated
}

}  // namespace
}  // namespace bs_car_odometry::calibration
