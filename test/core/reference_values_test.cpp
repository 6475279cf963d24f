// Reference values of docs/model.md, T1 to T7 and T14 to T19: twelve significant digits each, held to 1e-9.
#include "support/matchers.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/axle_odometry.hpp"
#include "bs_car_odometry/core/odometry_estimator.hpp"

#include <Eigen/Dense>

namespace bs_car_odometry {
namespace {

using namespace test_support;

constexpr double kTolerance = 1e-9;

/// T2 and T5: rear axle of a pivot car with base_link on it, so that the pose is that of the axle's middle.
Vehicle rearAxleAtBaseLink() {
  Vehicle vehicle = withMeasuredRear(pivotCar());
  vehicle.base_link_x = 0.0;
  return vehicle;
}

StepReadings readingsOfT2(double alpha_begin, double alpha_end) {
  StepReadings readings;
  readings.travel[Wheel::kRearRight] = 0.55;
  readings.travel[Wheel::kRearLeft] = 0.45;
  readings.begin.rear = alpha_begin;
  readings.end.rear = alpha_end;
  return readings;
}

BodyIncrement incrementOfT2(Motion motion, double alpha_begin, double alpha_end) {
  OdometryOptions options;
  options.motion = motion;
  const AxleOdometry odometry(rearAxleAtBaseLink(), noNoise(), options, Axle::kRear);
  return odometry.increment(readingsOfT2(alpha_begin, alpha_end));
}

const Pose2 kStartOfT2{1.0, 2.0, 0.7};

/// Columns S_r, S_l, alpha of dt/d(S_r, S_l, alpha), taken out of the sensitivities to gains and offset.
Eigen::Matrix3d J_motion_inputs(const BodyIncrement& increment) {
  Eigen::Matrix3d J;
  J << increment.J_motion_systematic.col(systematic::kRearRight) / 0.55,
      increment.J_motion_systematic.col(systematic::kRearLeft) / 0.45,
      increment.J_motion_systematic.col(systematic::kRearOffset);
  return J;
}

TEST(ReferenceValues, T1ExactArc) {
  const PoseStep step = advance({0.0, 0.0, 0.3}, BodyMotion(1.0, 0.0, 0.5));
  EXPECT_TRUE(relativelyNear(step.pose.x, 0.843671768476, kTolerance));
  EXPECT_TRUE(relativelyNear(step.pose.y, 0.517259559557, kTolerance));
}

TEST(ReferenceValues, T2PaperMotion) {
  const Pose2 pose = advance(kStartOfT2, incrementOfT2(Motion::kPaper, -0.3, -0.3).motion).pose;
  EXPECT_TRUE(matrixRelativelyNear(pose.vector(), Eigen::Vector3d(1.45160306693, 2.214603518, 0.787229300128),
                                   kTolerance));
}

TEST(ReferenceValues, T2AxleMotion) {
  const AxleMotion axle = pivotAxle(0.55, 0.45, -0.3, 0.0, 1.2, 0.0);
  EXPECT_TRUE(relativelyNear(axle.travel, 0.5, kTolerance));
  EXPECT_TRUE(relativelyNear(axle.heading, 0.0872293001282, kTolerance));
}

TEST(ReferenceValues, T2ExactMotion) {
  const Pose2 pose = advance(kStartOfT2, incrementOfT2(Motion::kExact, -0.3, -0.3).motion).pose;
  EXPECT_TRUE(matrixRelativelyNear(
      pose.vector(), Eigen::Vector3d(1.45145990448, 2.21453548666, 0.787229300128), kTolerance));
}

TEST(ReferenceValues, T3MovingSteering) {
  const BodyIncrement increment = incrementOfT2(Motion::kExact, -0.30, -0.26);
  EXPECT_TRUE(relativelyNear(increment.motion.z(), 0.0867102250416, kTolerance));
  EXPECT_TRUE(matrixRelativelyNear(advance(kStartOfT2, increment.motion).pose.vector(),
                                   Eigen::Vector3d(1.44697982065, 2.22332650919, 0.786710225042),
                                   kTolerance));
}

TEST(ReferenceValues, T4AxleModels) {
  constexpr double kOmega = 0.649030570514;
  Vehicle vehicle = cycab();
  vehicle.base_link_x = vehicle.wheelbase;  // on the front axle, alpha = phi_front
  const SteeringAngles steering = slaved(vehicle, 0.4);
  const Eigen::Vector3d twist = bodyTwist(vehicle, std::cos(0.4), steering);
  EXPECT_TRUE(relativelyNear(twist.z(), kOmega, kTolerance));
  const PerWheel<double> speeds = wheelSpeeds(vehicle, twist, steering);
  const double right = speeds[Wheel::kFrontRight];
  const double left = speeds[Wheel::kFrontLeft];
  EXPECT_TRUE(relativelyNear(right, 1.36711474874, kTolerance));
  EXPECT_TRUE(relativelyNear(left, 0.659007249146, kTolerance));

  const AxleMotion ackermann = ackermannAxle(right, left, 0.4, 1.2);
  EXPECT_TRUE(relativelyNear(ackermann.travel, 1.0, kTolerance));
  EXPECT_TRUE(relativelyNear(ackermann.heading, kOmega, kTolerance));
  const AxleMotion pivot = pivotAxle(right, left, 0.4, 0.0, 1.2, 0.0);
  EXPECT_TRUE(relativelyNear(pivot.travel, 1.01306099894, kTolerance));
  EXPECT_TRUE(relativelyNear(pivot.heading, 0.640662873402, kTolerance));

  const double delta_right = wheelDirection(vehicle, Wheel::kFrontRight, steering);
  const double delta_left = wheelDirection(vehicle, Wheel::kFrontLeft, steering);
  EXPECT_TRUE(relativelyNear(delta_right, 0.288846665217, kTolerance));
  EXPECT_TRUE(relativelyNear(delta_left, 0.63219459292, kTolerance));
  const AxleMotion directed = directedAxle(right, left, 0.4, delta_right, delta_left, 1.2);
  EXPECT_TRUE(relativelyNear(directed.travel, 1.0, kTolerance));
  EXPECT_TRUE(relativelyNear(directed.heading, kOmega, kTolerance));
}

TEST(ReferenceValues, T4AckermannAxleOnTheWheelsOfT2) {
  const AxleMotion axle = ackermannAxle(0.55, 0.45, -0.3, 1.2);
  EXPECT_TRUE(relativelyNear(axle.travel, 0.499758066415, kTolerance));
  EXPECT_TRUE(relativelyNear(axle.heading, 0.0872715279554, kTolerance));
}

TEST(ReferenceValues, T5Jacobians) {
  const BodyIncrement increment = incrementOfT2(Motion::kPaper, -0.3, -0.3);
  const PoseStep step = advance(kStartOfT2, increment.motion);
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F(0, 2) = -0.214603518004;
  F(1, 2) = 0.45160306693;
  EXPECT_TRUE(matrixRelativelyNear(step.J_pose_pose(), F, kTolerance));
  Eigen::Matrix3d G;
  G << 0.358004493527, 0.545201640332, -0.211708174837,  //
      0.411568615324, 0.0176384206835, 0.445510222479,   //
      0.872293001282, -0.872293001282, -0.0269831845577;
  const Eigen::Matrix3d J = step.J_pose_motion() * J_motion_inputs(increment);
  EXPECT_TRUE(matrixRelativelyNear(J, G, kTolerance));
}

/// T6 from its start covariance.
FirstOrderCovariance covarianceOfT6() {
  const BodyIncrement increment = incrementOfT2(Motion::kPaper, -0.3, -0.3);
  const Eigen::Matrix3d J = J_motion_inputs(increment);
  const Eigen::Vector3d variances(0.004 * 0.004, 0.005 * 0.005, 0.003 * 0.003);
  FirstOrderCovariance covariance(symmetric(4e-4, 1e-4, 5e-5, 3e-4, -4e-5, 1e-4));
  covariance.advance(advance(kStartOfT2, increment.motion), J * variances.asDiagonal() * J.transpose(),
                     SystematicSensitivity::Zero());
  return covariance;
}

TEST(ReferenceValues, T6FirstOrderCovariance) {
  EXPECT_TRUE(matrixRelativelyNear(covarianceOfT6().total(),
                                   symmetric(0.000393030294549, 0.000123221776988, 2.16982288938e-05,
                                             0.000288770599326, 1.04116031222e-05, 0.000131203251114),
                                   kTolerance));
}

TEST(ReferenceValues, T7StraightRun) {
  OdometryConfiguration configuration;
  configuration.vehicle = rearAxleAtBaseLink();
  configuration.noise = noNoise();
  configuration.noise.wheel = std::sqrt(4e-6 / 0.02);
  configuration.options.axles = AxleSelection::kRear;
  OdometryEstimator estimator(configuration);
  StepReadings readings;
  readings.travel[Wheel::kRearRight] = readings.travel[Wheel::kRearLeft] = 0.02;
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(estimator.step(readings, std::nullopt));
  EXPECT_TRUE(matrixRelativelyNear(
      estimator.estimate().pose_covariance,
      symmetric(2e-4, 0.0, 0.0, 0.000740722222222, 0.000555555555556, 0.000555555555556), kTolerance));
}

TEST(ReferenceValues, T14TwoSteeringAngles) {
  const Vehicle vehicle = cycab();
  const SteeringAngles steering{0.25, -0.2};
  const PathShape path = pathShape(vehicle, steering);
  EXPECT_TRUE(relativelyNear(path.curvature, 0.381709963941, kTolerance));
  EXPECT_TRUE(relativelyNear(path.sideslip, 0.0263159428562, kTolerance));
  const PerWheel<double> directions{{0.319823863108, 0.204845439636, -0.257107942959, -0.163463844478}};
  const PerWheel<double> speeds{{0.812157890295, 1.25527062908, 0.797177709505, 1.24563084981}};
  const PerWheel<double> rolled = wheelSpeeds(vehicle, bodyTwist(vehicle, 1.0, steering), steering);
  for (const Wheel wheel : kAllWheels) {
    EXPECT_TRUE(relativelyNear(wheelDirection(vehicle, wheel, steering), directions[wheel], kTolerance))
        << name(wheel);
    EXPECT_TRUE(relativelyNear(rolled[wheel], speeds[wheel], kTolerance)) << name(wheel);
  }
}

/// (W1) on the wheels of T15 plus `errors`, order fl fr rl rr.
class FitOfT15 {
 public:
  explicit FitOfT15(const Eigen::Vector4d& errors) : H_(fitEquations(FitGeometry(cycab()), {0.25, -0.25}).H) {
    const Eigen::Vector4d travels =
        Eigen::Vector4d(0.039360994367, 0.0640523777058, 0.039360994367, 0.0640523777058) + errors;
    const Eigen::Array2d axle_travel(0.5 * (travels(0) + travels(1)), 0.5 * (travels(2) + travels(3)));
    covariance_.wheels.setConstant(1e-6);
    covariance_.axles = (axle_travel * 5e-3).square() + 2e-4 * 2e-4;
    covariance_.shared = 0.0;
    solution = solveFit(H_, covariance_, travels);
  }

  Eigen::Matrix<double, 6, 1> normalised() const { return normalisedResiduals(H_, covariance_, solution); }

 private:
  FitMatrix<3> H_;
  FitCovariance covariance_;

 public:
  FitSolution solution;
};

TEST(ReferenceValues, T15CleanFit) {
  const FitSolution fit = FitOfT15(Eigen::Vector4d::Zero()).solution;
  // The wheels are given with twelve digits.
  EXPECT_TRUE(matrixNear(fit.motion, Eigen::Vector3d(0.05, 0.0, 0.0212784934351), 1e-12));
  EXPECT_LT(fit.chi_square, 1e-16);
  EXPECT_TRUE(matrixRelativelyNear(
      fit.P, symmetric(2.31262251634e-07, 0.0, 6.11524744173e-08, 5.59793426927e-08, 0.0, 1.47645141013e-07),
      kTolerance));
}

TEST(ReferenceValues, T15DisturbedFit) {
  const FitSolution fit = FitOfT15({-0.0005, 0.001, 0.0002, 0.0008}).solution;
  EXPECT_TRUE(matrixRelativelyNear(
      fit.motion, Eigen::Vector3d(0.0504267613094, -1.07760546158e-05, 0.0215743992736), kTolerance));
  EXPECT_TRUE(relativelyNear(fit.chi_square, 0.886361288193, kTolerance));
}

TEST(ReferenceValues, T15SlippingWheel) {
  const FitOfT15 fit({0.0, 0.0, 0.0, 0.008});
  EXPECT_TRUE(matrixRelativelyNear(
      fit.solution.motion, Eigen::Vector3d(0.0521527106399, -0.000105318122, 0.022614559687), kTolerance));
  EXPECT_TRUE(relativelyNear(fit.solution.chi_square, 39.393236581, kTolerance));
  Eigen::Matrix<double, 6, 1> w;
  w << -1.67521542516, -3.86335667308, -1.7479833415, 6.27640315634, -1.6099712672, 3.5693292921;
  EXPECT_TRUE(matrixRelativelyNear(fit.normalised(), w, kTolerance));
}

TEST(ReferenceValues, T16Exponential) {
  EXPECT_TRUE(matrixRelativelyNear(exp(BodyMotion(1.0, 0.2, 0.5)).vector(),
                                   Eigen::Vector3d(0.909884101965, 0.436605091661, 0.5), kTolerance));
}

/// From the rear axle to base_link midway, 0.6 m ahead: as if the axle's frame drove there.
TEST(ReferenceValues, T17FromAxleToBaseLink) {
  const PoseStep to_base_link = advance(kStartOfT2, BodyMotion(0.6, 0.0, 0.0));
  EXPECT_TRUE(matrixRelativelyNear(to_base_link.pose.vector(),
                                   Eigen::Vector3d(1.45890531237, 2.38653061234, 0.7), kTolerance));
  FirstOrderCovariance covariance = covarianceOfT6();
  covariance.advance(to_base_link, Eigen::Matrix3d::Zero(), SystematicSensitivity::Zero());
  EXPECT_TRUE(matrixRelativelyNear(covariance.total(),
                                   symmetric(0.000395858776836, 0.000105881848657, -2.90158441005e-05,
                                             0.000325957108004, 7.06214720586e-05, 0.000131203251114),
                                   kTolerance));
}

/// The radius error of T18, common to every wheel: uniform within +/-1 %.
SystematicCovariance commonRadiusError() {
  Eigen::Matrix<double, systematic::kCount, 1> all_wheels;
  all_wheels << 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0;
  return 0.01 * 0.01 / 3.0 * all_wheels * all_wheels.transpose();
}

TEST(ReferenceValues, T18ConstantRadiusError) {
  OdometryConfiguration configuration;
  configuration.vehicle = cycab();
  configuration.noise = noNoise();
  OdometryEstimator estimator(configuration);
  estimator.setSystematicCovariance(commonRadiusError());
  const StepReadings readings = consistentReadings(configuration.vehicle, 0.04, {});
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(estimator.step(readings, std::nullopt));
  EXPECT_TRUE(
      relativelyNear(std::sqrt(estimator.estimate().pose_covariance(0, 0)), 0.115470053838, kTolerance));
}

/// P1 (5) applied literally: the radius drawn anew in every step.
TEST(ReferenceValues, T18RedrawnRadiusError) {
  const WheelFit fit(cycab(), noNoise());
  const BodyIncrement increment = fit.increment(consistentReadings(cycab(), 0.04, {}));
  const SystematicSensitivity J = SystematicRoot(commonRadiusError())(increment.J_motion_systematic);
  FirstOrderCovariance covariance(Eigen::Matrix3d::Zero());
  for (int i = 0; i < 500; ++i)
    covariance.advance(advance({0.04 * i, 0.0, 0.0}, increment.motion), J * J.transpose(),
                       SystematicSensitivity::Zero());
  EXPECT_TRUE(relativelyNear(std::sqrt(covariance.total()(0, 0)), 0.00516397779494, kTolerance));
}

TEST(ReferenceValues, T19Sensitivities) {
  OdometryOptions options;
  options.motion = Motion::kPaper;
  const AxleOdometry odometry(rearAxleAtBaseLink(), noNoise(), options, Axle::kRear);
  StepReadings readings;
  readings.travel[Wheel::kRearRight] = 0.06;
  readings.travel[Wheel::kRearLeft] = 0.04;
  const double uniform = 0.01 / std::sqrt(3.0);
  const SystematicRoot root(systematicCovariance({uniform, uniform, uniform, 0.0}));

  Pose2 pose;
  FirstOrderCovariance covariance(Eigen::Matrix3d::Zero());
  for (int i = 0; i < 200; ++i) {
    const BodyIncrement increment = odometry.increment(readings);
    const PoseStep step = advance(pose, increment.motion);
    covariance.advance(step, increment.path_covariance, root(increment.J_motion_systematic));
    pose = step.pose;
  }
  EXPECT_TRUE(matrixRelativelyNear(
      pose.vector(), Eigen::Vector3d(-0.571710505623, 5.94509082282, 3.33333333333), kTolerance));
  const Eigen::Vector3d deviation = covariance.total().diagonal().cwiseSqrt();
  EXPECT_TRUE(matrixRelativelyNear(
      deviation, Eigen::Vector3d(0.200612553998, 0.162058854807, 0.0720082299823), kTolerance));
}

}  // namespace
}  // namespace bs_car_odometry
