// The methods that propagate uncertainty, against the reference values of docs/model.md, section 9, and
// against each other.
#include "paper2_rectangle.hpp"
#include "raw_moments.hpp"
#include "support/matchers.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/moment_uncertainty.hpp"
#include "bs_car_odometry/core/odometry_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace bs_car_odometry {
namespace {

using namespace test_support;

constexpr double kTolerance = 1e-9;

// --- T11, T12: one step of P2's robot
// -----------------------------------------------------------------------

/// P2's Euler step: along the heading before it.
PoseStep eulerStep(double heading, double travel) {
  PoseStep step;
  step.r = std::cos(heading);
  step.s = std::sin(heading);
  step.dx = travel * step.r;
  step.dy = travel * step.s;
  return step;
}

TEST(Paper2, T11SimplifiedForm) {
  Paper2Simplified simplified;
  BodyIncrement increment;
  increment.motion << 0.01, 0.0, 0.005;
  increment.path_covariance = differentialNoise(0.0012, 0.0008, 0.4);
  const Vehicle vehicle = cycab();
  const OdometryModel model = WheelFit(vehicle, NoiseModel());
  simplified.advance({eulerStep(0.6, 0.01), increment, SystematicSensitivity::Zero(), {}, model});
  EXPECT_TRUE(matrixRelativelyNear(simplified.total(),
                                   symmetric(3.54213016164e-07, 2.42330162351e-07, 8.2533561491e-07,
                                             1.65786983836e-07, 5.64642473395e-07, 1.3e-05),
                                   kTolerance));
}

const Eigen::Matrix3d kStartOfT12 = symmetric(0.04, 0.01, 0.05, 0.09, -0.03, 0.1225);
const Eigen::Vector3d kMeanOfT12(0.368742893135, 0.252270586008, 0.725);
const Eigen::Matrix3d kEndOfT12 =
    symmetric(0.024155433343, 0.0255903035465, 0.0206494548693, 0.0853561646651, 0.0162331963502, 0.14375);

TEST(Paper2, T12OneStepFromAJointGaussian) {
  GaussianStep step;
  step.displacement = 0.475;
  step.turn = 0.05 / 0.4;
  step.covariance = differentialNoise(0.05, 0.03, 0.4);
  step.direction = 0.0;  // Euler
  PoseMoments moments;
  moments.reset({0.0, 0.0, 0.6}, kStartOfT12);
  moments.advance(step);
  EXPECT_TRUE(matrixRelativelyNear(moments.mean().vector(), kMeanOfT12, kTolerance));
  EXPECT_TRUE(matrixRelativelyNear(moments.covariance(), kEndOfT12, kTolerance));
}

TEST(Paper2, T12ByTheRawForm) {
  const Eigen::Matrix3d P = differentialNoise(0.05, 0.03, 0.4);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of (D, eta, phi), phi = 0
  covariance(0, 0) = P(0, 0);
  covariance(0, 1) = covariance(1, 0) = P(0, 2);
  covariance(1, 1) = P(2, 2);
  RawMoments moments({0.0, 0.0, 0.6}, kStartOfT12);
  moments.advance({0.475, 0.125, 0.0}, covariance);
  EXPECT_TRUE(matrixRelativelyNear(moments.mean(), kMeanOfT12, kTolerance));
  EXPECT_TRUE(matrixRelativelyNear(moments.covariance(), kEndOfT12, kTolerance));
}

// --- T13: P2's rectangle
// ------------------------------------------------------------------------------------

struct RowOfT13 {
  std::size_t step;
  double var_x, var_y, cov_xy, var_yaw;
};

constexpr double kSigmaOfT13 = 1e-3;  // m, each wheel and step

/// Sums over 3152 steps of values that have twelve digits.
constexpr double kSumTolerance = 1e-8;

void expectRows(PoseUncertainty& method, const std::vector<RowOfT13>& rows) {
  std::size_t checked = 0;
  driveRectangle(method, kSigmaOfT13, [&](std::size_t step, const Eigen::Matrix3d& covariance) {
    for (const RowOfT13& row : rows) {
      if (row.step != step) continue;
      SCOPED_TRACE("after step " + std::to_string(step));
      ++checked;
      EXPECT_TRUE(relativelyNear(covariance(0, 0), row.var_x, kSumTolerance));
      EXPECT_TRUE(relativelyNear(covariance(1, 1), row.var_y, kSumTolerance));
      EXPECT_NEAR(covariance(0, 1), row.cov_xy, kSumTolerance);
      EXPECT_TRUE(relativelyNear(covariance(2, 2), row.var_yaw, kSumTolerance));
    }
  });
  EXPECT_EQ(checked, rows.size());
}

TEST(Paper2Rectangle, T13FirstOrder) {
  FirstOrderCovariance method(Eigen::Matrix3d::Zero());
  expectRows(method, {{1000, 0.0005, 0.4166665625, 0.0, 0.0125},
                      {1513, 0.307556328125, 0.4169073125, -0.2812399722, 0.0189125},
                      {2076, 0.307822078125, 0.33650634375, 0.081, 0.02595},
                      {2576, 0.308072078125, 1.553589625, 0.44325, 0.0322},
                      {2864, 0.153808117188, 1.553717875, 1.00278e-05, 0.0358},
                      {3152, 0.36201915625, 1.553846125, -0.44325, 0.0394}});
}

TEST(Paper2Rectangle, T13ExactMoments) {
  OdometryConfiguration configuration;
  configuration.vehicle = cycab();
  ExactMoments method(SystematicPrior(configuration), SystematicRule::kDegreeFive);
  expectRows(method, {{1000, 0.00178765437637, 0.413432763044, 0.0, 0.0125},
                      {1513, 0.303930500696, 0.41597767894, -0.276673012386, 0.0189125},
                      {2076, 0.307451521809, 0.332948646749, 0.0756847017908, 0.02595},
                      {2576, 0.327476578334, 1.51236829516, 0.426952634757, 0.0322},
                      {2864, 0.175579458147, 1.51272408688, 0.00508398168682, 0.0358},
                      {3152, 0.37344468342, 1.51934178187, -0.416210492647, 0.0394}});
  EXPECT_TRUE(matrixNear(method.noise().mean().vector(),
                         Eigen::Vector3d(0.0977109646883, 0.0437538577758, 6.28318530718), kSumTolerance));
}

TEST(Paper2Rectangle, T13ClosedFormWithCrossTerms) {
  ClosedForm method;
  driveRectangle(method, kSigmaOfT13, [](std::size_t, const Eigen::Matrix3d&) {});
  EXPECT_TRUE(relativelyNear(method.total()(0, 0), 0.349025173929, kSumTolerance));
  EXPECT_TRUE(relativelyNear(method.total()(1, 1), 1.51012510657, kSumTolerance));
}

TEST(Paper2Rectangle, T13Simplified) {
  Paper2Simplified method;
  const std::vector<RowOfT13> rows = {{1000, 0.0005, 3.125e-07, 0, 0},
                                      {1513, 0.000515890625, 0.0002410625, 0, 0},
                                      {2076, 0.000781640625, 0.00025696875, 0, 0},
                                      {2576, 0.001031640625, 0.000257125, 0, 0},
                                      {2864, 0.0010474609375, 0.000385375, 0, 0},
                                      {3152, 0.00106328125, 0.000513625, 0, 0}};
  std::size_t checked = 0;
  driveRectangle(method, kSigmaOfT13, [&](std::size_t step, const Eigen::Matrix3d& covariance) {
    for (const RowOfT13& row : rows) {
      if (row.step != step) continue;
      ++checked;
      EXPECT_TRUE(relativelyNear(covariance(0, 0), row.var_x, kSumTolerance));
      EXPECT_TRUE(relativelyNear(covariance(1, 1), row.var_y, kSumTolerance));
    }
  });
  EXPECT_EQ(checked, rows.size());
}

// --- T21, and the raw form against the central one -----------------------------------------------------

struct SteeredStep {
  Eigen::Vector3d mean;  ///< of (D, eta, phi)
  Eigen::Matrix3d covariance;
};

SteeredStep stepOfT21() {
  const double alpha = -0.3;
  const double k = 1.0 / (1.2 * std::cos(alpha));
  const double turn = k * (0.0326 - 0.0226);
  Eigen::Matrix3d A;
  A << 0.5, 0.5, 0.0,                 //
      k, -k, turn * std::tan(alpha),  //
      0.5 * k, -0.5 * k, 1.0 + 0.5 * turn * std::tan(alpha);
  const Eigen::Vector3d variances(1e-6, 1e-6, 5e-3 * 5e-3);
  return {{0.5 * (0.0326 + 0.0226), turn, alpha + 0.5 * turn}, A * variances.asDiagonal() * A.transpose()};
}

const Eigen::Vector3d kMeanOfT21(2.64846474558, 0.362808616702, 0.872293001282);
const Eigen::Matrix3d kEndOfT21 = symmetric(7.07309670203e-05, -8.09263835408e-05, -5.7260881698e-05,
                                            0.000352671394161, 0.000197297836296, 0.000152197218323);

TEST(ExactMoments, T21ByTheRawForm) {
  const SteeredStep step = stepOfT21();
  RawMoments moments(Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero());
  for (int i = 0; i < 100; ++i) moments.advance(step.mean, step.covariance);
  EXPECT_TRUE(matrixRelativelyNear(moments.mean(), kMeanOfT21, kTolerance));
  EXPECT_TRUE(matrixRelativelyNear(moments.covariance(), kEndOfT21, kTolerance));
}

/// The package lets the steering noise push the car sideways and does not turn the step by it, which would
/// shorten the path the more the oftener it is drawn: by Var(alpha)/2 = 1.25e-5 of the mean here.
TEST(ExactMoments, T21WithSteeringNoiseSideways) {
  const SteeredStep polar = stepOfT21();
  const double alpha = -0.3;
  // (D, eta, phi) to (D', eta) with D' = D e^{i alpha}: phi = alpha + eta/2 + d_alpha.
  Eigen::Matrix3d J;
  J << std::cos(alpha), polar.mean(0) * std::sin(alpha) * 0.5, -polar.mean(0) * std::sin(alpha),  //
      std::sin(alpha), -polar.mean(0) * std::cos(alpha) * 0.5, polar.mean(0) * std::cos(alpha),   //
      0.0, 1.0, 0.0;
  GaussianStep step;
  step.displacement = std::polar(polar.mean(0), alpha);
  step.turn = polar.mean(1);
  step.covariance = J * polar.covariance * J.transpose();
  PoseMoments moments;
  moments.reset({}, Eigen::Matrix3d::Zero());
  for (int i = 0; i < 100; ++i) moments.advance(step);
  EXPECT_TRUE(matrixRelativelyNear(moments.mean().vector(), kMeanOfT21, 1.5e-5));
  EXPECT_TRUE(matrixRelativelyNear(moments.covariance(), kEndOfT21, 1e-4));
}

/// From an uncertain pose, with heading deviations up to 0.7 rad: both forms are exact, so they agree.
TEST(ExactMoments, CentralFormIsTheRawForm) {
  const Eigen::Matrix3d P = 4.0 * differentialNoise(0.004, 0.003, 0.4);
  Eigen::Matrix3d polar;  // of (D, eta, phi = eta/2)
  polar << P(0, 0), P(0, 2), 0.5 * P(0, 2), P(0, 2), P(2, 2), 0.5 * P(2, 2), 0.5 * P(0, 2), 0.5 * P(2, 2),
      0.25 * P(2, 2);
  const Eigen::Vector3d start(0.3, -0.2, 0.6);
  PoseMoments central;
  central.reset({start.x(), start.y(), start.z()}, kStartOfT12);
  RawMoments raw(start, kStartOfT12);
  GaussianStep step;
  step.displacement = 0.05;
  step.turn = 0.02;
  step.covariance = P;
  for (int i = 0; i < 700; ++i) {
    central.advance(step);
    raw.advance({0.05, 0.02, 0.01}, polar);
  }
  ASSERT_GT(central.covariance()(2, 2), 0.49);
  EXPECT_TRUE(matrixRelativelyNear(central.mean().vector(), raw.mean(), 1e-11));
  EXPECT_TRUE(matrixRelativelyNear(central.covariance(), raw.covariance(), 1e-10));
}

// --- Constant errors of the parameters
// -----------------------------------------------------------------------

/// Mean and covariance of the end of a drive over one parameter a, by brute force: the drive with the
/// parameter as it is, for a fine grid of a within 6 standard deviations.
template <typename End>
Eigen::Matrix3d covarianceOver(const End& end, double sigma) {
  constexpr int kGrid = 120;  // the trapezoidal rule over a bell converges faster than any power
  double total = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  const Eigen::Vector3d nominal = end(0.0);
  for (int i = -kGrid; i <= kGrid; ++i) {
    const double z = 6.0 * i / kGrid;
    const double weight = std::exp(-0.5 * z * z);
    const Eigen::Vector3d d = end(z * sigma) - nominal;
    total += weight;
    mean += weight * d;
    square += weight * d * d.transpose();
  }
  mean /= total;
  return square / total - mean * mean.transpose();
}

/// 45 m of circle at 0.3 rad: as far as first order does not reach.
void driveCircle(OdometryEstimator& estimator, const Vehicle& sensors) {
  const StepReadings readings = consistentReadings(sensors, 0.03, slaved(sensors, 0.3));
  for (int i = 0; i < 1500; ++i) ASSERT_TRUE(estimator.step(readings, std::nullopt));
}

/// Standard deviations of the end of the circle, the track of the rear axle off by 1 %: a heading of 0.23
/// rad.
constexpr double kTrackError = 0.01;

Eigen::Vector3d circleDeviations(SystematicRule rule) {
  OdometryConfiguration configuration;
  configuration.vehicle = cycab();
  configuration.noise = noNoise();
  configuration.noise.systematic.k_b = kTrackError;
  configuration.options.axles = AxleSelection::kRear;
  configuration.options.uncertainty = Uncertainty::kExactMoments;
  configuration.options.systematic_rule = rule;
  OdometryEstimator estimator(configuration);
  driveCircle(estimator, cycab());
  return dynamic_cast<const ExactMoments&>(estimator.uncertainty()).central().diagonal().cwiseSqrt();
}

/// The same by brute force; `gain` makes k_b of its error.
template <typename Gain>
Eigen::Vector3d trueDeviations(const Gain& gain) {
  const auto end = [&](double error) {
    OdometryConfiguration configuration;
    configuration.vehicle = cycab();
    configuration.vehicle.gains.rear.k_b = gain(error);
    configuration.noise = noNoise();
    configuration.options.axles = AxleSelection::kRear;
    OdometryEstimator estimator(configuration);
    driveCircle(estimator, cycab());
    return estimator.estimate().pose.vector();
  };
  return covarianceOver(end, kTrackError).diagonal().cwiseSqrt();
}

TEST(SystematicNodes, CircleWithAWrongTrack) {
  const Eigen::Vector3d linear_in_a = trueDeviations([](double error) { return 1.0 / (1.0 - error); });
  const Eigen::Vector3d expected = trueDeviations([](double error) { return 1.0 + error; });
  const Eigen::Vector3d nodes = circleDeviations(SystematicRule::kDegreeFive);
  const Eigen::Vector3d sensitivity = circleDeviations(SystematicRule::kSensitivity);
  std::cout << "  brute force " << expected.transpose() << "\n  the same, increments linear in the error "
            << linear_in_a.transpose() << "\n  nodes       " << nodes.transpose() << "\n  Phi         "
            << sensitivity.transpose() << std::endl;
  // Within a segment the nodes are moved to first order.
  EXPECT_TRUE(matrixRelativelyNear(nodes, linear_in_a, 4e-4));
  // A turn goes with 1/k_b, of which the rule knows the first order only.
  EXPECT_TRUE(matrixRelativelyNear(nodes, expected, 0.025));
  EXPECT_GT(std::abs(sensitivity.x() / expected.x() - 1.0), 0.05);  // the drive can tell the two apart
}

// --- Laws that every method keeps
// ----------------------------------------------------------------------------

const std::vector<Uncertainty> kMethods = {Uncertainty::kFirstOrder, Uncertainty::kExactMoments,
                                           Uncertainty::kClosedForm, Uncertainty::kPaper2Simplified};

OdometryConfiguration configured(Uncertainty method, AxleSelection axles = AxleSelection::kBoth) {
  OdometryConfiguration configuration;
  configuration.vehicle = cycab();
  configuration.options.uncertainty = method;
  configuration.options.axles = axles;
  configuration.initial_pose.covariance = symmetric(1e-4, 2e-5, 1e-5, 2e-4, -1e-5, 3e-4);
  return configuration;
}

void driveCurve(OdometryEstimator& estimator, int steps, double travel = 0.03) {
  for (int i = 0; i < steps; ++i) {
    const double angle = 0.3 * std::sin(0.01 * i);
    ASSERT_TRUE(estimator.step(consistentReadings(cycab(), travel, slaved(cycab(), angle)), std::nullopt));
  }
}

class Methods : public testing::TestWithParam<Uncertainty> {};

TEST_P(Methods, StandstillChangesNothingAtAll) {
  OdometryEstimator estimator(configured(GetParam()));
  driveCurve(estimator, 200);
  const OdometryEstimate before = estimator.estimate();
  StepReadings standing;
  standing.begin = standing.end = slaved(cycab(), 0.3);
  for (int i = 0; i < 100000; ++i) ASSERT_TRUE(estimator.step(standing, std::nullopt));
  EXPECT_EQ(estimator.estimate().pose.vector(), before.pose.vector());
  EXPECT_EQ(estimator.estimate().pose_covariance, before.pose_covariance);
}

/// A car that is the same from behind, rear axle included, driven backwards: the mirrored drive.
TEST_P(Methods, ForwardEqualsReverse) {
  OdometryConfiguration configuration = configured(GetParam());
  configuration.initial_pose.covariance.setZero();
  configuration.noise.rear_law = 0.0;  // only the rear axle has it
  OdometryEstimator forward(configuration);
  OdometryEstimator reverse(configuration);
  driveCurve(forward, 300, 0.03);
  driveCurve(reverse, 300, -0.03);
  const Eigen::Vector3d mirror(-1.0, 1.0, -1.0);
  const Eigen::Matrix3d mirrored =
      mirror.asDiagonal() * reverse.estimate().pose_covariance * mirror.asDiagonal();
  EXPECT_TRUE(matrixRelativelyNear(mirrored, forward.estimate().pose_covariance, 1e-9));
}

TEST_P(Methods, OtherParametersKeepThePast) {
  OdometryEstimator estimator(configured(GetParam()));
  driveCurve(estimator, 200);
  const Eigen::Matrix3d before = estimator.estimate().pose_covariance;
  estimator.setSystematicCovariance(SystematicCovariance::Zero());
  EXPECT_TRUE(matrixRelativelyNear(estimator.uncertainty().total(), before, 1e-14));
}

TEST_P(Methods, UnseenMotionAdds) {
  OdometryEstimator estimator(configured(GetParam()));
  driveCurve(estimator, 50);
  const Eigen::Matrix3d before = estimator.estimate().pose_covariance;
  estimator.inflate(durationFromSeconds(0.02));
  const Eigen::Matrix3d grown = estimator.estimate().pose_covariance - before;
  const Eigen::Vector3d expected(0.64, 0.64, 0.64 / 1.44);  // up to 40 m/s for 0.02 s
  // With exact moments, what heading errors of the parameters do to the noise (micrometres here) fades with
  // the noise of the heading.
  EXPECT_TRUE(matrixNear(grown, Eigen::Matrix3d(expected.asDiagonal()), 1e-8));
}

TEST_P(Methods, SetPoseForgetsThePast) {
  OdometryEstimator estimator(configured(GetParam()));
  OdometryEstimator fresh(configured(GetParam()));
  driveCurve(estimator, 100);
  const Eigen::Matrix3d covariance = symmetric(1e-3, 2e-4, 1e-4, 2e-3, -1e-4, 3e-3);
  for (OdometryEstimator* each : {&estimator, &fresh}) {
    each->setPose({1.0, 2.0, 0.3}, covariance);
    driveCurve(*each, 100);
  }
  EXPECT_EQ(estimator.estimate().pose_covariance, fresh.estimate().pose_covariance);
}

INSTANTIATE_TEST_SUITE_P(All, Methods, testing::ValuesIn(kMethods), methodName);

}  // namespace
}  // namespace bs_car_odometry
