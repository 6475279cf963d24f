// Dead reckoning with gains that get better, and the paths before and after.

#include "bs_car_odometry/calibration/dead_reckoning.hpp"
#include "bs_car_odometry/calibration/driven_paths.hpp"
#include "car_with_laser.hpp"

#include <gmock/gmock.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <cmath>
#include <iostream>
#include <vector>

namespace bs_car_odometry::calibration {
namespace {

/// A drive with everything that the node makes of it.
struct Reckoned {
  explicit Reckoned(const CarSettings& settings)
      : calibrator(settings.parameters),
        car(settings),
        reckoning(settings.parameters),
        paths(settings.parameters) {
    calibrator.setListener([this](const CalibrationUpdate& update) {
      if (reckoning.correct(update)) paths.start();
      paths.add(update);
      take();
    });
    car.setListener([this](const OdometryUpdate& update) {
      reckoning.add(update);
      take();
    });
  }

  void take() {
    while (const std::optional<DeadReckonedPose> pose = reckoning.next()) {
      paths.add(pose->step);
      poses.push_back(*pose);
    }
  }

  Calibrator calibrator;
  CarWithLaser car;
  DeadReckoning reckoning;
  DrivenPaths paths;
  std::vector<DeadReckonedPose> poses;
};

CarSettings driveOf(const std::string& scenario, std::uint64_t seed) {
  CarSettings settings;
  settings.scenario = scenarioNamed(scenario);
  settings.seed = seed;
  std::cout << "seed " << seed << "\n";
  return settings;
}

double distanceBetween(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

TEST(DeadReckoning, goesOnWithoutAJumpWhateverTheLaserAndTheGainsDo) {
  CarSettings settings = driveOf("slalom_eight", 2);
  settings.disturb = [](double time, Pose2& pose) {
    if (time > 20.0) pose.x += 1.0;
  };
  Reckoned reckoned(settings);
  reckoned.car.driveUntil(40.0, reckoned.calibrator);
  EXPECT_EQ(reckoned.calibrator.counts().relocalisations, 1u);
  // One for each step at 50 Hz, from the second laser pose on: the first one is where the filter begins.
  EXPECT_EQ(reckoned.poses.size(), 1995u);
  for (std::size_t i = 1; i < reckoned.poses.size(); ++i) {
    const DeadReckonedPose& pose = reckoned.poses[i];
    EXPECT_EQ(pose.stamp - reckoned.poses[i - 1].stamp, std::chrono::milliseconds(20));
    // 20 mm a step at 1 m/s, wrong gains and the noise of two wheels.
    EXPECT_LT(distanceBetween(pose.pose, reckoned.poses[i - 1].pose), 0.03) << i;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(pose.covariance, Eigen::EigenvaluesOnly);
    EXPECT_GE(solver.eigenvalues().minCoeff(), -1e-12 * solver.eigenvalues().maxCoeff());
  }
}

/// What the odometry's own fit lets pass, another with other gains may not.
TEST(DeadReckoning, O1_noStepIsLongerThanMaxSpeedAllows) {
  const CarSettings settings = driveOf("slalom_eight", 2);
  Reckoned reckoned(settings);
  OdometryUpdate newest{};
  reckoned.car.setListener([&](const OdometryUpdate& update) {
    newest = update;
    reckoned.reckoning.add(update);
    reckoned.take();
  });
  reckoned.car.driveUntil(5.0, reckoned.calibrator);
  const DeadReckonedPose before = reckoned.poses.back();
  ASSERT_EQ(before.stamp, newest.stamp);
  newest.step->span = {newest.stamp, newest.stamp + std::chrono::milliseconds(20)};
  newest.stamp = newest.step->span.end;
  const double travel = 1.5 * longestStep(settings.parameters.limits, std::chrono::milliseconds(20));
  newest.step->readings.travel.values.fill(travel);
  reckoned.reckoning.add(newest);
  reckoned.take();
  const DeadReckonedPose& after = reckoned.poses.back();
  ASSERT_EQ(after.stamp, newest.stamp);
  EXPECT_EQ(after.pose.vector(), before.pose.vector());
  const double unseen = std::pow(settings.parameters.limits.max_speed * 0.02, 2);
  EXPECT_GT(after.covariance(0, 0), before.covariance(0, 0) + unseen);
  EXPECT_GT(after.covariance(1, 1), before.covariance(1, 1) + unseen);
}

/// 50 drives: the squared distance of the end from the truth by the covariance has mean 3 or, since that is
/// an upper bound, less; without the share of the gains it would be far more.
TEST(DeadReckoning, itsCovarianceCoversItsErrors) {
  constexpr int kDrives = 50;
  double nees = 0.0;
  for (std::uint64_t seed = 1; seed <= kDrives; ++seed) {
    Reckoned reckoned(driveOf("fig4", seed));
    reckoned.car.driveUntil(15.0, reckoned.calibrator);
    const DeadReckonedPose& end = reckoned.poses.back();
    Eigen::Vector3d error = end.pose.vector() - reckoned.car.truePose().vector();
    error.z() = wrapAngle(error.z());
    nees += error.dot(end.covariance.llt().solve(error)) / kDrives;
  }
  std::cout << "mean NEES " << nees << "\n";
  EXPECT_LT(nees, 4.3);  // 99.9 % of means of 50 chi-square variables with 3 degrees of freedom
  EXPECT_GT(nees, 0.5);
}

TEST(DrivenPaths, beforeAndAfter) {
  CarSettings settings = driveOf("slalom_eight", 3);
  settings.noise = false;
  Reckoned reckoned(settings);
  reckoned.car.driveUntil(60.0, reckoned.calibrator);
  const Pose2 truth = reckoned.car.truePose();
  const Pose2 before = reckoned.paths.path(reckoned.paths.configured()).back();
  const Pose2 after = reckoned.paths.path(reckoned.car.trueValues()).back();
  // A piece of 0.1 m is not there yet; the motion is linear in 3 % of a gain to 1e-4 of a piece.
  EXPECT_LT(distanceBetween(after, truth), 0.13);
  EXPECT_NEAR(wrapAngle(after.yaw - truth.yaw), 0.0, 0.05);
  EXPECT_GT(distanceBetween(before, truth), 1.0);
  EXPECT_LT(distanceBetween(reckoned.paths.laserPath().back(), truth), 0.2);
}

/// Of a long drive the pieces get longer; joined, they lead to the same place.
TEST(DrivenPaths, stayShortOnALongDrive) {
  CarSettings settings = driveOf("slalom_eight", 3);
  settings.noise = false;
  Reckoned reckoned(settings);
  reckoned.car.driveUntil(900.0, reckoned.calibrator);
  const std::vector<Pose2> path = reckoned.paths.path(reckoned.car.trueValues());
  EXPECT_LE(path.size(), DrivenPaths::kMostPoses);
  EXPECT_GT(path.size(), DrivenPaths::kMostPoses / 3);
  EXPECT_LE(reckoned.paths.laserPath().size(), DrivenPaths::kMostPoses);
  // Of 900 m; a piece may be missing, and pieces of 0.8 m are linear in 3 % of a gain to 0.2 %.
  EXPECT_LT(distanceBetween(path.back(), reckoned.car.truePose()), 2.7);
}

}  // namespace
}  // namespace bs_car_odometry::calibration
