// The calibration's input over time: late, mixed up, wrong and missing poses, and time that is not seen.

#include "calibration_drive.hpp"
#include "support/figure.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <iostream>
#include <vector>

namespace bs_car_odometry::calibration {
namespace {

using laboratory::Sample;

constexpr std::uint64_t kSeed = 5;

/// A car with the gains of the scenarios, 20 s of an eight.
class Input : public ::testing::Test {
 protected:
  void SetUp() override {
    std::cout << "seed " << kSeed << "\n";
    Vehicle car = parameters_.vehicle;
    car.gains = {{1.02, 0.99, 1.03}, {1.02, 0.99, 1.03}};
    laboratory::DriveSettings settings;
    settings.scenario = "slalom_eight";
    settings.rate = 50.0;
    settings.duration = 20.0;
    settings.noise = parameters_.noise;
    settings.seed = kSeed;
    drive_ = laboratory::record(car, settings);
    lasers_ = laserPoses(drive_, parameters_, kSeed);
  }

  FilterEstimate calibrated(const std::vector<LaserPose>& lasers, std::size_t delay = 0) {
    Calibrator calibrator(parameters_);
    calibrate(calibrator, parameters_, drive_, lasers, delay);
    counts_ = calibrator.counts();
    return calibrator.estimate();
  }

  /// Largest difference of a parameter, in standard deviations of the first.
  static double difference(const FilterEstimate& a, const FilterEstimate& b) {
    double largest = 0.0;
    for (Eigen::Index i = 0; i < a.values.size(); ++i)
      if (a.covariance(i, i) > 0.0)
        largest = std::max(largest, std::abs(a.values[i] - b.values[i]) / std::sqrt(a.covariance(i, i)));
    return largest;
  }

  Parameters parameters_ = testParameters();
  std::vector<Sample> drive_;
  std::vector<LaserPose> lasers_;
  LaserCounts counts_;
};

/// Poses that come later than the steps after them are taken at their own stamps: not one bit differs, but
/// for those that the end of the drive leaves on their way.
TEST_F(Input, lateness_changes_nothing) {
  Calibrator prompt(parameters_);
  Calibrator late(parameters_);
  const std::vector<Sample> whole = drive_;
  calibrate(late, parameters_, drive_, lasers_, 90);
  drive_.resize(whole.size() - 90);
  calibrate(prompt, parameters_, drive_, lasers_);
  EXPECT_EQ(prompt.counts().used, late.counts().used);
  EXPECT_EQ((prompt.estimate().values - late.estimate().values).cwiseAbs().maxCoeff(), 0.0);
}

TEST_F(Input, poses_too_late_are_dropped) {
  Calibrator calibrator(parameters_);
  calibrate(calibrator, parameters_, drive_, lasers_, 250);
  EXPECT_EQ(calibrator.counts().used, 0u);
  EXPECT_GT(calibrator.counts().dropped, 100u);
  EXPECT_EQ(calibrator.stage(), CalibrationStage::kStart);
}

TEST_F(Input, what_is_no_pose_is_dropped) {
  Calibrator calibrator(parameters_);
  LaserPose laser = lasers_.front();
  laser.pose.x = NAN;
  EXPECT_EQ(calibrator.add(laser), LaserVerdict::kNotFinite);
  laser = lasers_.front();
  laser.covariance(1, 1) = -1.0;
  EXPECT_EQ(calibrator.add(laser), LaserVerdict::kBadCovariance);
  EXPECT_EQ(calibrator.add(lasers_[1]), LaserVerdict::kAccepted);
  EXPECT_EQ(calibrator.add(lasers_[0]), LaserVerdict::kOutOfOrder);
  EXPECT_EQ(calibrator.counts().dropped, 3u);
}

/// Two of the first five poses a kilometre off: the beginning is one of the other three.
TEST_F(Input, a_wrong_first_pose_is_not_begun_at) {
  std::vector<LaserPose> lasers = lasers_;
  lasers[0].pose.x += 1000.0;
  lasers[2].pose.y -= 1000.0;
  // One and two poses fewer of 200: their information is worth some hundredths of a standard deviation.
  const FilterEstimate clean = calibrated(lasers_);
  EXPECT_LT(difference(clean, calibrated(lasers)), 0.2);
  EXPECT_EQ(counts_.relocalisations, 0u);
  EXPECT_GE(counts_.rejected, 2u);
}

/// Row C3: 5 % outliers of up to 5 m, and a gain moves by less than 0.1 %.
TEST_F(Input, C3_outliers_move_the_gains_by_less_than_a_thousandth) {
  const FilterEstimate clean = calibrated(lasers_);
  laboratory::LaserErrors errors;
  errors.outliers = 0.05;
  errors.position = 5.0;
  errors.yaw = 0.0;
  const FilterEstimate disturbed = calibrated(laserPoses(drive_, parameters_, kSeed, errors));
  const double moved = (clean.values - disturbed.values).cwiseAbs().maxCoeff();
  EXPECT_LT(moved, 1e-3);
  EXPECT_GT(counts_.rejected, 3u);
  recordFigure("5 %% outliers of up to 5 m move a gain by %.3f %% at most", 100.0 * moved);
}

/// Counters that begin anew half way: the pose in between is not known, the gains go on.
TEST_F(Input, restarted_counters_leave_the_gains) {
  const FilterEstimate whole = calibrated(lasers_);
  for (std::size_t i = drive_.size() / 2; i < drive_.size(); ++i)
    for (std::int64_t& ticks : drive_[i].ticks.values) ticks -= 10000000;
  const FilterEstimate restarted = calibrated(lasers_);
  // A new first fix costs the pose that was known, and no more than that: estimates of which one knows less
  // differ by the difference of their covariances. Three standard deviations.
  const ParameterVector lost = (restarted.covariance - whole.covariance).diagonal();
  for (Eigen::Index i = 0; i < lost.size(); ++i) {
    if (whole.covariance(i, i) == 0.0) continue;
    EXPECT_LT(std::abs(restarted.values[i] - whole.values[i]), 3.0 * std::sqrt(lost[i]))
        << parameterName(static_cast<std::size_t>(i));
  }
  EXPECT_LT(restarted.covariance(0, 0), 1.1 * whole.covariance(0, 0));
}

TEST_F(Input, a_new_drive_goes_on_with_the_gains_and_a_start_does_not) {
  Calibrator calibrator(parameters_);
  calibrate(calibrator, parameters_, drive_, lasers_);
  const double first = calibrator.estimate().covariance(0, 0);
  calibrator.newDrive();
  // The map of another day.
  std::vector<LaserPose> moved = lasers_;
  for (LaserPose& laser : moved) laser.pose = Pose2{100.0, -50.0, 2.0} * laser.pose;
  calibrate(calibrator, parameters_, drive_, moved);
  EXPECT_NEAR(calibrator.estimate().covariance(0, 0), 0.5 * first, 0.05 * first) << "twice the information";
  EXPECT_EQ(calibrator.counts().relocalisations, 0u);
  calibrator.start();
  EXPECT_EQ(calibrator.estimate().covariance(0, 0), std::pow(parameters_.calibration.prior.k_r, 2));
  EXPECT_EQ(calibrator.estimate().values, valuesOf(parameters_));
  EXPECT_EQ(calibrator.stage(), CalibrationStage::kStart);
}

/// A laser off the middle and 60 ms late, offset and scale of the steering: each within 4 of its own standard
/// deviations, and none so large that this would say nothing.
TEST_F(Input, mount_delay_and_steering_are_found) {
  parameters_.calibration.estimate = {"gains", "steering_offset", "steering_scale", "laser_mount",
                                      "time_offset"};
  // One of steering offset and laser yaw is known, since they look nearly the same.
  Vehicle car = parameters_.vehicle;
  car.gains = {{1.02, 0.99, 1.03}, {1.02, 0.99, 1.03}};
  car.steering.front = {1.03, 0.01};
  laboratory::DriveSettings settings;
  settings.scenario = "slalom_eight";
  settings.rate = 50.0;
  settings.noise = parameters_.noise;
  settings.seed = kSeed;
  drive_ = laboratory::record(car, settings);
  Parameters truth = parameters_;
  truth.vehicle = car;
  truth.laser.x = 0.15;
  truth.laser.y = -0.1;
  truth.laser.yaw = 0.05;
  truth.laser.time_offset = 0.06;
  const FilterEstimate estimate = calibrated(laserPoses(drive_, truth, kSeed), 5);
  const ParameterVector error = estimate.values - valuesOf(truth);
  for (const std::size_t k :
       {std::size_t{systematic::kFrontOffset}, std::size_t{kFrontScale}, std::size_t{kLaserX},
        std::size_t{kLaserY}, std::size_t{kLaserYaw}, std::size_t{kTimeOffset}}) {
    const auto i = static_cast<Eigen::Index>(k);
    const double deviation = std::sqrt(estimate.covariance(i, i));
    EXPECT_LT(std::abs(error[i]), 4.0 * deviation) << parameterName(k);
    EXPECT_LT(deviation, 0.02) << parameterName(k);
  }
}

}  // namespace
}  // namespace bs_car_odometry::calibration
