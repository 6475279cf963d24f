// Errata of P1 (docs/model.md, section 10): what is printed fails against an independent judge, what the
// package does holds. Those of the calibration, E07 to E11, are judged as formulas, for the filter that will
// use them.
#include "support/matchers.hpp"
#include "support/seeded_generator.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/axle_odometry.hpp"
#include "bs_car_odometry/core/odometry_estimator.hpp"

#include <Eigen/Dense>

#include <functional>

namespace bs_car_odometry {
namespace {

using namespace test_support;

/// Integral of f over [0, end] by Simpson's rule; with 2000 intervals and f of order one to 1e-13.
double integral(const std::function<double(double)>& f, double end) {
  constexpr int kIntervals = 2000;
  const double h = end / kIntervals;
  double sum = f(0.0) + f(end);
  for (int i = 1; i < kIntervals; ++i) sum += (i % 2 == 1 ? 4.0 : 2.0) * f(i * h);
  return sum * h / 3.0;
}

/// Rear axle with base_link on it, so that the pose is that of the axle's middle, and its angle measured.
Vehicle rearAxleAtBaseLink(Vehicle vehicle) {
  vehicle = withMeasuredRear(vehicle);
  vehicle.base_link_x = 0.0;
  return vehicle;
}

StepReadings rearReadings(double right, double left, double alpha_begin, double alpha_end) {
  StepReadings readings;
  readings.travel[Wheel::kRearRight] = right;
  readings.travel[Wheel::kRearLeft] = left;
  readings.begin.rear = alpha_begin;
  readings.end.rear = alpha_end;
  return readings;
}

/// World system before (1): "x + rho (sin Psi - sin(Psi + dPsi))", y with cos the other way round.
TEST(Errata, E01SignsOfTheWorldSystem) {
  const double Psi = 0.3;
  const double dPsi = 0.5;
  const double dS = 1.0;
  const double rho = dS / dPsi;
  const Eigen::Vector2d printed(rho * (std::sin(Psi) - std::sin(Psi + dPsi)),
                                rho * (std::cos(Psi + dPsi) - std::cos(Psi)));
  const Eigen::Vector2d judge(integral([&](double s) { return std::cos(Psi + s / rho); }, dS),
                              integral([&](double s) { return std::sin(Psi + s / rho); }, dS));
  const PoseStep step = advance({0.0, 0.0, Psi}, BodyMotion(dS, 0.0, dPsi));
  EXPECT_TRUE(matrixNear(step.pose.position(), judge, 1e-12));
  EXPECT_TRUE(matrixNear(printed, -judge, 1e-12));  // exactly backwards
}

// --- E02: a pivot axle whose angle swings, alpha(t) = sin(t)/2 at 1 m/s for 2 s
// ---------------------------------------------------------------------------

constexpr double kSwingTrack = 1.2;
double swingAngle(double t) { return 0.5 * std::sin(t); }
double swingHeading(double t) { return 0.4 * t + 0.1 * std::sin(2.0 * t); }
double swingYawRate(double t) { return 0.4 + 0.2 * std::cos(2.0 * t); }

Eigen::Vector2d swingEnd(double end) {
  const auto direction = [](double t) { return swingHeading(t) + swingAngle(t); };
  return {integral([&](double t) { return std::cos(direction(t)); }, end),
          integral([&](double t) { return std::sin(direction(t)); }, end)};
}

/// Right less left travel from t to t + h: the wheels run at 1 +/- (B/2) dtheta/dt cos(alpha).
double swingDifference(double t, double h) {
  const auto rate = [](double s) { return kSwingTrack * swingYawRate(s) * std::cos(swingAngle(s)); };
  return integral([&](double s) { return rate(t + s); }, h);
}

/// Distance from the true end after `steps` steps, each (dS, S_r - S_l, alpha before, alpha after).
template <typename Step>
double swingError(int steps, const Step& step) {
  const double end = 2.0;
  const double h = end / steps;
  Pose2 pose;
  for (int i = 0; i < steps; ++i)
    pose = step(pose, h, swingDifference(i * h, h), swingAngle(i * h), swingAngle((i + 1) * h));
  return (pose.position() - swingEnd(end)).norm();
}

/// II-C: "dPsi = dtheta" because the steering is frozen in a step, while (2) takes the new alpha_i.
TEST(Errata, E02SteeringMovesWithinAStep) {
  const auto printed = [](const Pose2& from, double dS, double difference, double, double alpha) {
    const double turn = difference / (kSwingTrack * std::cos(alpha));
    const double psi = from.yaw + alpha + 0.5 * turn;
    return Pose2{from.x + dS * std::cos(psi), from.y + dS * std::sin(psi), from.yaw + turn};
  };
  const AxleOdometry axle(rearAxleAtBaseLink(pivotCar()), noNoise(), OdometryOptions(), Axle::kRear);
  const auto package = [&](const Pose2& from, double dS, double difference, double before, double after) {
    const StepReadings readings = rearReadings(dS + 0.5 * difference, dS - 0.5 * difference, before, after);
    return from * exp(axle.increment(readings).motion);
  };
  // Half the step: half the error of a method of first order, a quarter with second order.
  EXPECT_NEAR(swingError(100, printed) / swingError(200, printed), 2.0, 0.1);
  EXPECT_NEAR(swingError(100, package) / swingError(200, package), 4.0, 0.1);
  EXPECT_GT(swingError(100, printed), 4e-3);
  EXPECT_LT(swingError(100, package), 4e-5);
}

/// II-C and (9), (10): "dtheta = (S_r - S_l)/(B cos alpha)" as the relation for every steered axle.
TEST(Errata, E03ParallelAgainstAckermannWheels) {
  const double alpha = 0.4;
  const double track = 1.2;
  const double yaw_rate = 2.0 * std::sin(alpha) / track;
  const double c = std::cos(alpha);
  const double w = 0.5 * track * yaw_rate;  // the contact points move with (V c +/- w, V s), V = 1
  const double right = std::hypot(c + w, std::sin(alpha));
  const double left = std::hypot(c - w, std::sin(alpha));
  const double printed = (right - left) / (track * c);
  EXPECT_NEAR(printed / yaw_rate, 1.0 - 0.0129, 5e-5);
  EXPECT_TRUE(relativelyNear(ackermannAxle(right, left, alpha, track).heading, yaw_rate, 1e-14));
  EXPECT_TRUE(relativelyNear(ackermannAxle(right, left, alpha, track).travel, 1.0, 1e-14));
  // Parallel wheels read the part of their velocity along alpha, and there the printed relation is exact.
  const auto along = [&](double vx) { return vx * c + std::sin(alpha) * std::sin(alpha); };
  const AxleMotion pivot = pivotAxle(along(c + w), along(c - w), alpha, 0.0, track, 0.0);
  EXPECT_TRUE(relativelyNear(pivot.heading, yaw_rate, 1e-14));
}

/// (4), (5): "p(A)" integrated in every step, which draws the wheels' radii anew in each.
TEST(Errata, E04ParametersAreDrawnOnce) {
  const double radius_variance = 0.01 * 0.01 / 3.0;  // uniform within +/-1 %
  SeededGenerator generator(4);
  double judge = 0.0;
  double printed = 0.0;
  constexpr int kCars = 5000;
  for (int car = 0; car < kCars; ++car) {
    const double radius = generator.normal(radius_variance);
    double once = 0.0;
    double redrawn = 0.0;
    for (int step = 0; step < 500; ++step) {
      once += 0.04 * radius;
      redrawn += 0.04 * generator.normal(radius_variance);
    }
    judge += once * once / kCars;
    printed += redrawn * redrawn / kCars;
  }
  OdometryConfiguration configuration;
  configuration.vehicle = cycab();
  configuration.noise = noNoise();
  OdometryEstimator estimator(configuration);
  Eigen::Matrix<double, systematic::kCount, 1> all_wheels;
  all_wheels << 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0;
  estimator.setSystematicCovariance(radius_variance * all_wheels * all_wheels.transpose());
  for (int step = 0; step < 500; ++step)
    ASSERT_TRUE(estimator.step(consistentReadings(cycab(), 0.04, {}), std::nullopt));
  // The variance of 5000 draws is known to 2 %; four times that.
  EXPECT_TRUE(relativelyNear(estimator.estimate().pose_covariance(0, 0), judge, 0.08));
  EXPECT_LT(printed, judge / 400.0);  // 500 draws average out
}

// --- E05, E06: one step (M-1) from an uncertain pose, numbers of T2 and T6
// --------------------------------------------------------------------------------

const Pose2 kStartOfT2{1.0, 2.0, 0.7};
const Eigen::Vector3d kReadingsOfT2(0.55, 0.45, -0.3);
const Eigen::Matrix3d kSigmaOfT6 = symmetric(4e-4, 1e-4, 5e-5, 3e-4, -4e-5, 1e-4);
const Eigen::Vector3d kReadingDeviationsOfT6(0.004, 0.005, 0.003);

/// f of (6), written out: (S_r, S_l, alpha) and the pose before give the pose after.
Eigen::Vector3d stepOfPaper1(const Eigen::Vector3d& pose, const Eigen::Vector3d& readings) {
  const double dS = 0.5 * (readings(0) + readings(1));
  const double turn = (readings(0) - readings(1)) / (1.2 * std::cos(readings(2)));
  const double psi = pose(2) + readings(2) + 0.5 * turn;
  return pose + Eigen::Vector3d(dS * std::cos(psi), dS * std::sin(psi), turn);
}

/// Covariance after the step, by 400 000 draws: each variance to 0.22 %.
Eigen::Matrix3d simulatedStep() {
  SeededGenerator generator(5);
  const Eigen::Matrix3d root = kSigmaOfT6.llt().matrixL();
  const auto draw = [&] {
    return Eigen::Vector3d(generator.normal(1.0), generator.normal(1.0), generator.normal(1.0));
  };
  const Eigen::Vector3d nominal = stepOfPaper1(kStartOfT2.vector(), kReadingsOfT2);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  constexpr int kDraws = 400000;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d pose = kStartOfT2.vector() + root * draw();
    const Eigen::Vector3d readings = kReadingsOfT2 + kReadingDeviationsOfT6.cwiseProduct(draw());
    const Eigen::Vector3d error = stepOfPaper1(pose, readings) - nominal;
    mean += error / kDraws;
    square += error * error.transpose() / kDraws;
  }
  return square - mean * mean.transpose();
}

/// The package's step of T2 with the noise of T6.
struct PackageStep {
  PoseStep moved;
  Eigen::Matrix3d P;
};

PackageStep packageStep() {
  OdometryOptions options;
  options.motion = Motion::kPaper;
  const AxleOdometry axle(rearAxleAtBaseLink(pivotCar()), noNoise(), options, Axle::kRear);
  const BodyIncrement increment = axle.increment(rearReadings(0.55, 0.45, -0.3, -0.3));
  Eigen::Matrix3d J;  // columns S_r, S_l, alpha, out of the sensitivities to gains and offset
  J << increment.J_motion_systematic.col(systematic::kRearRight) / 0.55,
      increment.J_motion_systematic.col(systematic::kRearLeft) / 0.45,
      increment.J_motion_systematic.col(systematic::kRearOffset);
  const Eigen::Vector3d variances = kReadingDeviationsOfT6.cwiseAbs2();
  return {advance(kStartOfT2, increment.motion), J * variances.asDiagonal() * J.transpose()};
}

Eigen::Matrix3d packageCovariance() {
  const PackageStep step = packageStep();
  FirstOrderCovariance covariance(kSigmaOfT6);
  covariance.advance(step.moved, step.P, SystematicSensitivity::Zero());
  return covariance.total();
}

/// Four times what 400 000 draws leave open, and 0.1 % of curvature.
constexpr double kDrawTolerance = 0.01;

/// (7): "Sigma_{X_{i-1}} + J Sigma J^T" with the full Jacobian J of f.
TEST(Errata, E05CovarianceBeforeCountsTwice) {
  const Eigen::Matrix3d judge = simulatedStep();
  const PackageStep step = packageStep();
  const Eigen::Matrix3d F = step.moved.J_pose_pose();
  const Eigen::Matrix3d G = step.moved.J_pose_motion();
  const auto added = [&](const Eigen::Matrix3d& transition) -> Eigen::Matrix3d {
    return transition * kSigmaOfT6 * transition.transpose() + G * step.P * G.transpose();
  };
  const Eigen::Array3d expected = judge.diagonal();
  const Eigen::Array3d printed = (kSigmaOfT6 + added(F)).diagonal();
  // Were f the increment alone, J would be that of the increment, and the cross terms would be missing.
  const Eigen::Array3d of_increment = (kSigmaOfT6 + added(F - Eigen::Matrix3d::Identity())).diagonal();
  EXPECT_TRUE(matrixRelativelyNear(packageCovariance().diagonal(), expected.matrix(), kDrawTolerance));
  EXPECT_GT((printed / expected).minCoeff(), 1.7);
  EXPECT_GT((of_increment / expected - 1.0).abs().maxCoeff(), 0.05);
}

/// (8): leading "Sigma_{X_{i-1}}", and "Sigma_{(X_{i-1},S)}" both between J_X and between J_S.
TEST(Errata, E06CovarianceGrowsAtRest) {
  constexpr int kPose = 3;
  constexpr int kReadings = 3;
  using JointCovariance = Eigen::Matrix<double, kPose + kReadings, kPose + kReadings>;
  using J_X = Eigen::Matrix<double, kPose, kPose>;
  using J_S = Eigen::Matrix<double, kPose, kReadings>;
  static_assert(
      static_cast<int>(J_X::ColsAtCompileTime) != static_cast<int>(JointCovariance::RowsAtCompileTime) &&
          static_cast<int>(J_S::ColsAtCompileTime) != static_cast<int>(JointCovariance::RowsAtCompileTime),
      "as printed, the products do not even conform");
  // With the blocks that do conform, a car that stands still and reads nothing but zeros forgets where it is.
  const PoseStep rest = advance(kStartOfT2, BodyMotion::Zero());
  const Eigen::Matrix3d F = rest.J_pose_pose();
  const Eigen::Matrix3d printed = kSigmaOfT6 + F * kSigmaOfT6 * F.transpose();
  FirstOrderCovariance covariance(kSigmaOfT6);
  covariance.advance(rest, Eigen::Matrix3d::Zero(), SystematicSensitivity::Zero());
  EXPECT_EQ(covariance.total(), kSigmaOfT6);
  EXPECT_EQ(printed, 2.0 * kSigmaOfT6);
}

/// IV-C: "wheels base B", which reads as the wheelbase.
TEST(Errata, E12TrackAndNotWheelbase) {
  Vehicle car = ordinaryCar();  // wheelbase 2.7, track 1.55
  car.axle_geometry = AxleGeometry::kPivot;
  const double radius =
      4.0;  // a quarter of a circle about a point on the rear axle, whose wheels are straight
  const double right = (radius + 0.5 * car.track.rear) * M_PI_2;
  const double left = (radius - 0.5 * car.track.rear) * M_PI_2;
  const AxleOdometry axle(car, noNoise(), OdometryOptions(), Axle::kRear);
  EXPECT_NEAR(axle.increment(rearReadings(right, left, 0.0, 0.0)).motion.z(), M_PI_2, 1e-14);
  const double printed = (right - left) / car.wheelbase;
  EXPECT_NEAR(printed, M_PI_2 * 1.55 / 2.7, 1e-14);
}

}  // namespace
}  // namespace bs_car_odometry
