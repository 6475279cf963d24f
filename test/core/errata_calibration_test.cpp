// Errata E07 to E11: P1's calibration (docs/model.md, section 10). They are judged as formulas, by a motion
// that is known; the filter of the calibration takes the corrected ones.
#include "support/matchers.hpp"
#include "support/seeded_generator.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/axle_odometry.hpp"
#include "bs_car_odometry/core/first_order_covariance.hpp"

#include <Eigen/Dense>

namespace bs_car_odometry {
namespace {

using namespace test_support;

/// An axle of wheels that are not alike, and what P1's parametrisation has for them.
constexpr double kRight = 1.02;  // k_r
constexpr double kLeft = 0.99;   // k_l
constexpr double kZetaRight = 2.0e-4;
constexpr double kZetaLeft = 2.02e-4;
constexpr double kTrack = 1.2;
constexpr double kAngle = 0.2;
/// What a straight run with equal counts gives: k_d (zeta_r + zeta_l) = k_r zeta_r + k_l zeta_l.
constexpr double kDistanceGain = (kRight * kZetaRight + kLeft * kZetaLeft) / (kZetaRight + kZetaLeft);
constexpr double kZetaA = kDistanceGain * (kZetaRight + kZetaLeft);  // E07, corrected

/// The motion that is known.
constexpr double kTravel = 0.05;   // dS [m]
constexpr double kHeading = 0.01;  // dtheta [rad]

/// Pulses of that motion, by the geometry of parallel wheels.
struct Pulses {
  double right;
  double left;
};

Pulses pulses() {
  const double half = 0.5 * kHeading * kTrack * std::cos(kAngle);
  return {(kTravel + half) / (kRight * kZetaRight), (kTravel - half) / (kLeft * kZetaLeft)};
}

/// (9): what the package makes of these pulses, given the travel of the left wheel.
AxleMotion axleWithLeft(double left_travel) {
  return pivotAxle(kRight * kZetaRight * pulses().right, left_travel, kAngle, 0.0, kTrack, 0.0);
}

/// IV-C: "zeta_a = k_d (zeta_r E_r + zeta_l E_l)", though (10) multiplies it by pulses.
TEST(Errata, E07MetresPerPulse) {
  const Pulses E = pulses();
  const auto left = [&](double zeta_a) { return (zeta_a - kRight * kZetaRight) * E.left; };
  const double printed = kDistanceGain * (kZetaRight * E.right + kZetaLeft * E.left);
  EXPECT_TRUE(relativelyNear(axleWithLeft(left(kZetaA)).travel, kTravel, 1e-13));
  EXPECT_GT(axleWithLeft(left(printed)).travel, 200.0 * kTravel);  // times the pulses of a sample
}

/// (10), first line: "(zeta_a - k_r zeta_l) E_l" in dS.
TEST(Errata, E08LeftTravelInTheDistance) {
  const double E_l = pulses().left;
  EXPECT_TRUE(relativelyNear(axleWithLeft((kZetaA - kRight * kZetaRight) * E_l).travel, kTravel, 1e-13));
  const double printed = axleWithLeft((kZetaA - kRight * kZetaLeft) * E_l).travel;
  // zeta_l is 1 % larger than zeta_r, and half of the left wheel's travel goes into dS.
  EXPECT_NEAR(printed / kTravel, 1.0 - 0.0045, 1e-5);
}

/// (10), second line: "(zeta_a - k_l zeta_l) E_l" in dtheta.
TEST(Errata, E09LeftTravelInTheHeading) {
  const double E_l = pulses().left;
  EXPECT_TRUE(relativelyNear(axleWithLeft((kZetaA - kRight * kZetaRight) * E_l).heading, kHeading, 1e-12));
  // It is the travel of the right wheel's gain by the left wheel's pulses: the turn is wrong altogether.
  const double printed = axleWithLeft((kZetaA - kLeft * kZetaLeft) * E_l).heading;
  EXPECT_GT(std::abs(printed / kHeading - 1.0), 0.04);
}

/// (10) on the straight run: E_r = E_l is implied. T8: 50 000 pulses of the right wheel.
TEST(Errata, E10PulseTotalsOfTheStraightRun) {
  const double N_r = 50000.0;
  const double distance = kRight * kZetaRight * N_r;
  const double N_l = distance / (kLeft * kZetaLeft);  // straight: both wheels go as far
  const double nominal = kZetaRight * N_r + kZetaLeft * N_l;
  const double k_d = 2.0 * distance / nominal;
  EXPECT_TRUE(relativelyNear(N_l, 51005.1005101, 1e-9));
  EXPECT_TRUE(relativelyNear(k_d, 1.0047761194, 1e-9));
  const double printed = (k_d * (kZetaRight + kZetaLeft) - kRight * kZetaRight) / kZetaLeft;
  const double corrected = (k_d * nominal - kRight * kZetaRight * N_r) / (kZetaLeft * N_l);
  EXPECT_TRUE(relativelyNear(printed, 0.989702970297, 1e-9));
  EXPECT_TRUE(relativelyNear(corrected, kLeft, 1e-14));
}

// --- E11: a straight of 10 m, a bend of 6 m, and a laser at its end
// --------------------------------------------------------------------------

constexpr double kDistanceGainError = 0.003;

/// Readings of the drive, with gains of 1 and no noise.
std::vector<StepReadings> straightAndBend() {
  const Vehicle car = pivotCar();
  std::vector<StepReadings> drive(200, consistentReadings(car, 0.05, {}));
  drive.insert(drive.end(), 120, consistentReadings(car, 0.05, slaved(car, 0.3)));
  return drive;
}

AxleOdometry rearAxle() {
  NoiseModel noise = noNoise();
  noise.wheel = 0.005;
  return AxleOdometry(pivotCar(), noise, OdometryOptions(), Axle::kRear);
}

/// End pose to first order in the gains and the noise.
FirstOrderCovariance endToFirstOrder() {
  const AxleOdometry axle = rearAxle();
  FirstOrderCovariance covariance(Eigen::Matrix3d::Zero());
  Pose2 pose;
  for (const StepReadings& readings : straightAndBend()) {
    const BodyIncrement increment = axle.increment(readings);
    const PoseStep step = advance(pose, increment.motion);
    covariance.advance(step, increment.path_covariance, increment.J_motion_systematic);
    pose = step.pose;
  }
  return covariance;
}

/// End pose of a car whose right and left gain are these, with noise drawn for each step.
Pose2 simulatedEnd(double k_r, double k_l, SeededGenerator* generator) {
  const AxleOdometry axle = rearAxle();
  const double c = 0.005;
  Pose2 pose;
  for (StepReadings readings : straightAndBend()) {
    double& right = readings.travel[Wheel::kRearRight];
    double& left = readings.travel[Wheel::kRearLeft];
    if (generator != nullptr) {
      const double noise_right = generator->normal(c * c * right);
      const double noise_left = generator->normal(c * c * left);
      right += noise_right;
      left += noise_left;
    }
    right *= k_r;
    left *= k_l;
    pose = pose * exp(axle.increment(readings).motion);
  }
  return pose;
}

/// Mean squared error of (k_r, k_b) in units of the covariance that the estimate from one laser pose claims.
/// The left gain is k_l = 2 k_d - k_r; `k_d_variance` is what the estimate believes of k_d.
double meanNees(double k_d_variance) {
  const FirstOrderCovariance end = endToFirstOrder();
  const auto& Phi = end.sensitivity();
  Eigen::Matrix3d H;  // columns k_r, k_b, k_d
  H << Phi.col(systematic::kRearRight) - Phi.col(systematic::kRearLeft), Phi.col(systematic::kRearTrack),
      2.0 * Phi.col(systematic::kRearLeft);
  const Eigen::Vector3d laser(0.02, 0.02, 0.005);
  const Eigen::Matrix3d R = end.noise() + Eigen::Matrix3d(laser.cwiseAbs2().asDiagonal()) +
                            k_d_variance * H.col(2) * H.col(2).transpose();
  const Eigen::Matrix<double, 3, 2> H_free = H.leftCols<2>();
  const Eigen::Matrix2d information = H_free.transpose() * R.inverse() * H_free;
  const Eigen::Vector3d nominal = simulatedEnd(1.0, 1.0, nullptr).vector();
  SeededGenerator generator(11);
  double sum = 0.0;
  constexpr int kDrives = 2000;
  for (int i = 0; i < kDrives; ++i) {
    const double k_d_error = generator.normal(kDistanceGainError * kDistanceGainError);
    // True are k_r = k_b = 1; what k_d is off by, the left wheel has.
    Eigen::Vector3d z = simulatedEnd(1.0, 1.0 + 2.0 * k_d_error, &generator).vector() - nominal;
    for (int k = 0; k < 3; ++k) z(k) += generator.normal(laser(k) * laser(k));
    const Eigen::Vector2d error = information.inverse() * H_free.transpose() * R.inverse() * z;
    sum += error.dot(information * error);
  }
  return sum / kDrives;
}

/// IV-C: k_d is called a "heading error gain", and what it is uncertain by is dropped.
TEST(Errata, E11FrozenDistanceGain) {
  const double printed = meanNees(0.0);
  const double corrected = meanNees(kDistanceGainError * kDistanceGainError);
  std::cout << "mean NEES: frozen " << printed << ", its variance kept " << corrected << "\n";
  // 2 degrees of freedom, 2000 drives: standard deviation of the mean 0.045; 99.9 % of means lie within 0.15.
  EXPECT_NEAR(corrected, 2.0, 0.15);
  EXPECT_GT(printed, 10.0);
}

}  // namespace
}  // namespace bs_car_odometry
