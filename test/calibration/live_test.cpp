// What a calibration that runs for hours on a car must survive (docs/reliability.md, rows C2, C4, C6, C8).

#include "bs_car_odometry/calibration/joint_filter.hpp"
#include "bs_car_odometry/calibration/observability.hpp"
#include "car_with_laser.hpp"

#include "bs_car_odometry/laboratory/chi_square.hpp"
#include "bs_car_odometry/simulation/random.hpp"

#include "support/figure.hpp"

#include <gmock/gmock.h>
#include <Eigen/Eigenvalues>

#include <cmath>
#include <iostream>
#include <vector>

namespace bs_car_odometry::calibration {
namespace {

using simulation::Command;

CarSettings driveOf(simulation::Scenario scenario, std::uint64_t seed = 1) {
  CarSettings settings;
  settings.scenario = std::move(scenario);
  settings.seed = seed;
  std::cout << "seed " << seed << "\n";
  return settings;
}

/// Largest distance of two estimates' estimated parameters, in standard deviations of the first.
double deviationsApart(const FilterEstimate& a, const FilterEstimate& b, const ParameterMask& estimated) {
  double largest = 0.0;
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (estimated[i])
      largest = std::max(largest, std::abs(a.values[k] - b.values[k]) / std::sqrt(a.covariance(k, k)));
  }
  return largest;
}

/// Smallest eigenvalue of a covariance's correlations, of those parameters that have a variance.
double smallestEigenvalue(const Eigen::MatrixXd& P) {
  const Eigen::VectorXd scale = P.diagonal().unaryExpr(
      [](double variance) { return variance > 0.0 ? 1.0 / std::sqrt(variance) : 1.0; });
  const Eigen::MatrixXd correlations = scale.asDiagonal() * P * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlations, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .minCoeff();
}

// --- C2: covariances that are none -------------------------------------------------------------------------

/// Positive definite or not, well or badly conditioned, of any size.
Eigen::Matrix3d randomMatrix(simulation::Random& random) {
  Eigen::Matrix3d A;
  for (Eigen::Index i = 0; i < A.size(); ++i) A.data()[i] = random.normal();
  const double size = std::pow(10.0, 6.0 * random.normal());
  Eigen::Matrix3d matrix = size * size * A * A.transpose();
  if (random.normal() > 0.0) matrix = size * (A + A.transpose());
  if (random.normal() > 1.5) matrix(0, 0) = std::nan("");
  return matrix;
}

TEST(Live, C2_noCovarianceMakesTheFiltersOneNegative) {
  constexpr int kMatrices = 100000;
  CarSettings settings = driveOf(scenarioNamed("slalom_eight"), 7);
  Calibrator calibrator(settings.parameters);
  CarWithLaser car(settings);
  car.driveUntil(5.0, calibrator);
  simulation::Random random(7, 1);
  int accepted = 0;
  double smallest = 1.0;
  double time = 5.0;
  calibrator.setListener([&](const CalibrationUpdate& update) {
    ++accepted;
    ASSERT_TRUE(update.estimate.covariance.allFinite() && update.estimate.pose_covariance.allFinite());
    ASSERT_TRUE(update.estimate.values.allFinite() && update.estimate.pose.isFinite());
    smallest = std::min({smallest, smallestEigenvalue(update.estimate.covariance),
                         smallestEigenvalue(update.estimate.pose_covariance)});
  });
  for (int i = 0; i < kMatrices; ++i) {
    time += 0.0002;
    car.driveUntil(time, calibrator);
    LaserPose laser;
    laser.stamp = timeFromNanoseconds(1600000000000000000) + durationFromSeconds(time);
    laser.pose = car.truePose();
    laser.covariance = randomMatrix(random);
    calibrator.add(laser);
  }
  EXPECT_GT(accepted, kMatrices / 10) << "some of them are positive definite";
  EXPECT_GT(calibrator.counts().dropped, static_cast<std::uint64_t>(kMatrices / 10)) << "and some are not";
  // Rounding of a 9 x 9 matrix in double precision.
  EXPECT_GT(smallest, -1e-9);
  std::cout << accepted << " accepted, smallest eigenvalue of the correlations " << smallest << "\n";
  recordFigure("%d random matrices: no eigenvalue of the correlations below %.0e", kMatrices,
               -roundedUp(-smallest));
}

/// The same place twice, believed without limit, and places at the end of all numbers.
TEST(Live, C1_posesBeyondAllMeasureLeaveTheFilterSound) {
  CarSettings settings = driveOf(scenarioNamed("fig4"));
  Calibrator calibrator(settings.parameters);
  CarWithLaser car(settings);
  car.driveUntil(5.0, calibrator);
  LaserPose laser;
  laser.stamp = timeFromNanoseconds(1600000000000000000) + durationFromSeconds(5.0);
  for (const double variance : {5e-324, 1e-300, 1e-4, 1e300})
    for (const double x : {1.7e308, -1.7e308, 1e150, 1e9, 0.0, 1e-4}) {
      laser.stamp += Duration(1);
      laser.pose = car.truePose();
      laser.pose.x += x;
      laser.covariance = variance * Eigen::Matrix3d::Identity();
      calibrator.add(laser);
      const FilterEstimate estimate = calibrator.estimate();
      ASSERT_TRUE(estimate.values.allFinite() && estimate.covariance.allFinite()) << x << ' ' << variance;
      ASSERT_TRUE(estimate.pose.isFinite() && estimate.pose_covariance.allFinite()) << x << ' ' << variance;
      ASSERT_TRUE(std::isfinite(calibrator.innovation().nis) &&
                  std::isfinite(calibrator.innovation().weight));
    }
}

TEST(Live, C2_aRefusedPoseChangesNothing) {
  CarSettings settings = driveOf(scenarioNamed("fig4"));
  Calibrator calibrator(settings.parameters);
  CarWithLaser car(settings);
  car.driveUntil(5.0, calibrator);
  const FilterEstimate before = calibrator.estimate();
  LaserPose laser;
  laser.stamp = timeFromNanoseconds(1600000000000000000) + durationFromSeconds(5.0) + Duration(1);
  laser.pose = car.truePose();
  for (const double bad : {0.0, -1e-4, std::nan("")}) {
    laser.covariance = bad * Eigen::Matrix3d::Identity();
    EXPECT_EQ(calibrator.add(laser), LaserVerdict::kBadCovariance) << bad;
  }
  laser.covariance = Eigen::Matrix3d::Identity();
  laser.pose.x = std::nan("");
  EXPECT_EQ(calibrator.add(laser), LaserVerdict::kNotFinite);
  EXPECT_EQ(calibrator.estimate().values, before.values);
  EXPECT_EQ(calibrator.estimate().covariance, before.covariance);
  EXPECT_EQ(calibrator.counts().dropped, 4u);
}

// --- C4: the localiser jumps -------------------------------------------------------------------------------

TEST(Live, C4_aJumpOfTheLocaliserIsFollowed) {
  constexpr double kJump = 30.0;  // s
  const Pose2 moved{1.0, 0.0, 20.0 * M_PI / 180.0};
  CarSettings settings = driveOf(scenarioNamed("slalom_eight"), 3);
  CarSettings jumping = settings;
  double shift = 0.0;  // m, of the latest laser pose
  jumping.disturb = [&moved, &shift](double time, Pose2& pose) {
    if (time <= kJump) return;
    const Pose2 elsewhere = moved * pose;
    shift = (elsewhere.position() - pose.position()).norm();
    pose = elsewhere;
  };
  Calibrator undisturbed(settings.parameters);
  Calibrator calibrator(settings.parameters);
  std::vector<LocaliserJump> jumps;
  calibrator.setListener([&](const CalibrationUpdate& update) {
    if (!update.jump) return;
    jumps.push_back(*update.jump);
    // Three standard deviations of the pose, as below.
    EXPECT_NEAR(update.jump->distance, shift, 0.06);
    EXPECT_NEAR(update.jump->turn, moved.yaw, 0.015);
  });
  CarWithLaser quiet_car(settings);
  CarWithLaser car(jumping);
  // Ten poses of 10 Hz make a jump; twice that is allowed.
  quiet_car.driveUntil(kJump + 2.0, undisturbed);
  car.driveUntil(kJump + 2.0, calibrator);
  EXPECT_EQ(calibrator.counts().relocalisations, 1u);
  ASSERT_EQ(jumps.size(), 1u);
  const Time first = timeFromNanoseconds(1600000000000000000) + durationFromSeconds(kJump + 0.1);
  EXPECT_EQ(jumps[0].stamp, first) << "the first pose from the new place";
  const Pose2 expected = moved * car.truePose();
  const Pose2 found = calibrator.estimate().pose;
  EXPECT_LT(std::hypot(found.x - expected.x, found.y - expected.y), 0.06) << "three standard deviations";
  EXPECT_NEAR(wrapAngle(found.yaw - expected.yaw), 0.0, 0.015);
  const double apart = deviationsApart(undisturbed.estimate(), calibrator.estimate(), calibrator.estimated());
  recordFigure("1 m and 20 degrees: gains within %.2f standard deviations of those without", apart);
  EXPECT_LT(apart, 0.2);
}

// --- C6: standing for hours
// ----------------------------------------------------------------------------------

TEST(Live, C6_eightHoursParkedThenAnHourOfDriving) {
  constexpr double kParked = 8.0 * 3600.0;
  constexpr double kDriven = 3600.0;
  CarSettings settings =
      driveOf(scenarioOf(kParked + kDriven,
                         [](double time) {
                           if (time < kParked) return Command{};
                           const double speed = std::min(1.0, 0.5 * (time - kParked));
                           return Command{speed, 0.3 * std::sin(2.0 * M_PI * (time - kParked) / 20.0), 0.0};
                         }),
              5);
  settings.rate = 10.0;
  settings.steps_per_pose = 1;
  Calibrator calibrator(settings.parameters);
  CarWithLaser car(settings);
  double nis = 0.0;
  std::size_t poses = 0;
  calibrator.setListener([&](const CalibrationUpdate& update) {
    nis += update.innovation.nis;
    ++poses;
  });
  car.driveUntil(kParked, calibrator);
  EXPECT_EQ(calibrator.counts().used, 288000u) << "and the pose of the beginning";
  std::cout << "parked: mean NIS " << nis / static_cast<double>(poses) << "\n";
  EXPECT_FALSE(calibrator.allGainsObserved()) << "standing shows nothing";
  nis = 0.0;
  poses = 0;
  car.driveUntil(kParked + kDriven, calibrator);
  std::cout << "driven: mean NIS " << nis / static_cast<double>(poses) << "\n";
  EXPECT_TRUE(calibrator.allGainsObserved());
  const laboratory::Interval bounds = laboratory::meanInterval(3, poses);
  EXPECT_TRUE(bounds.holds(nis / static_cast<double>(poses)))
      << nis / static_cast<double>(poses) << ", allowed " << bounds.low << " to " << bounds.high;
  const FilterEstimate estimate = calibrator.estimate();
  const ParameterVector error = estimate.values - car.trueValues();
  double largest = 0.0;
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!calibrator.estimated()[i]) continue;
    std::cout << parameterName(i) << " " << error[k] << " +/- " << std::sqrt(estimate.covariance(k, k))
              << "\n";
    // 0.1 %: what theory promises after an hour is below the model's own error at 10 Hz.
    EXPECT_NEAR(error[k], 0.0, 0.002) << parameterName(i);
    largest = std::max(largest, std::abs(error[k]));
  }
  recordFigure("8 hours parked, one driven: gains within %.2f %% of the truth, mean NIS %.2f of 3 dimensions",
               100.0 * largest, nis / static_cast<double>(poses));
}

// --- C8: poses that come late
// ----------------------------------------------------------------------------------

TEST(Live, C8_aPoseIsTakenAtItsStampHoweverLateItComes) {
  CarSettings settings = driveOf(scenarioNamed("slalom_eight"), 11);
  Calibrator at_once(settings.parameters);
  CarWithLaser(settings).driveUntil(60.0, at_once);
  double largest = 0.0;
  for (const double latency : {0.1, 1.9}) {
    settings.laser_latency = latency;
    Calibrator late(settings.parameters);
    CarWithLaser(settings).driveUntil(60.0 + latency, late);
    // Poses of the last seconds may still be on the way.
    for (const std::size_t gain : {systematic::kFrontRight, systematic::kRearLeft, systematic::kRearTrack}) {
      const auto k = static_cast<Eigen::Index>(gain);
      EXPECT_NEAR(late.estimate().values[k], at_once.estimate().values[k], 1e-3) << latency << " s late";
      largest = std::max(largest, std::abs(late.estimate().values[k] - at_once.estimate().values[k]));
    }
    EXPECT_EQ(late.counts().dropped, 0u);
  }
  recordFigure("0.1 and 1.9 s late: gains differ by %g at most from those by prompt poses",
               roundedUp(largest));
}

TEST(Live, C8_poses100MillisecondsLateMoveNoGain) {
  CarSettings settings = driveOf(scenarioNamed("slalom_eight"), 11);
  settings.noise = false;
  settings.laser_latency = 0.1;
  Calibrator calibrator(settings.parameters);
  CarWithLaser car(settings);
  car.driveUntil(60.0, calibrator);
  const ParameterVector error = calibrator.estimate().values - car.trueValues();
  std::cout << "errors " << error.head<systematic::kCount>().transpose() << "\n";
  EXPECT_LT(error.head<systematic::kCount>().cwiseAbs().maxCoeff(), 1e-3);
}

TEST(Live, C8_posesFiveSecondsLateAreDropped) {
  CarSettings settings = driveOf(scenarioNamed("slalom_eight"), 11);
  settings.laser_latency = 5.0;
  Calibrator calibrator(settings.parameters);
  CarWithLaser(settings).driveUntil(20.0, calibrator);
  EXPECT_EQ(calibrator.counts().used, 0u);
  EXPECT_EQ(calibrator.counts().dropped, 150u + 1u);
}

// --- first fix
// -------------------------------------------------------------------------------------------------

/// The first pose is an outlier: the beginning is another one, and all of the good ones count as good.
TEST(Live, beginsElsewhereWhenTheFirstPoseIsWrong) {
  CarSettings settings = driveOf(scenarioNamed("slalom_eight"), 13);
  settings.disturb = [](double time, Pose2& pose) {
    if (time < 0.05) pose.x += 3.0;
  };
  Calibrator calibrator(settings.parameters);
  CarWithLaser car(settings);
  car.driveUntil(1.0, calibrator);
  EXPECT_EQ(calibrator.counts().rejected, 1u);
  EXPECT_NEAR(calibrator.estimate().pose.x, car.truePose().x, 0.05);
}

}  // namespace
}  // namespace bs_car_odometry::calibration
