#include "bs_car_odometry/calibration/leave_one_out.hpp"

#include "simulated_calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace bs_car_odometry::calibration {
namespace {

class LeaveOneOut : public ::testing::Test {
 protected:
  LeaveOneOut() {
    SimulatedDrive simulated;
    simulated.noise = parameters_.noise;
    simulated.laser_sigma = parameters_.laser_sigma;
    simulated.truth = valuesOf(parameters_);
    simulated.truth.segment<3>(systematic::kRearRight) << 1.02, 0.99, 1.03;
    truth_ = simulated.truth;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      simulated.seed = seed;
      simulated.scenario = seed == 3 ? "slalom_eight" : "fig4";
      calibrated_.push_back(calibrate(simulated, parameters_));
    }
    for (const CalibratedDrive& calibrated : calibrated_) drives_.push_back(&calibrated.drive);
  }

  Parameters parameters_{cycabParameters()};
  ParameterVector truth_;
  std::vector<CalibratedDrive> calibrated_;
  Drives drives_;
};

TEST_F(LeaveOneOut, GainsOfTheOthersMakeTheDriftSmall) {
  const Refinement all = refine(drives_, parameters_);
  const std::vector<LeftOutDrive> left_out = leaveOneOut(drives_, parameters_, all);
  ASSERT_EQ(left_out.size(), 3U);
  EXPECT_NEAR(left_out[0].nominal.distance, 19.0, 0.5);
  EXPECT_NEAR(left_out[2].nominal.distance, 60.0, 1.5);
  for (const LeftOutDrive& drive : left_out) {
    EXPECT_TRUE(drive.refined.converged);
    EXPECT_GT(drive.nominal.percent(), 5.0);     // gains 2, -1, 3 % off
    EXPECT_LT(drive.calibrated.percent(), 2.5);  // noise of the wheels and of the first heading: about 1 %
    EXPECT_LT(drive.all.percent(), 2.5);
  }
}

TEST_F(LeaveOneOut, KnowsNothingOfTheDriveThatIsLeftOut) {
  const Refinement others = refine({drives_[1], drives_[2]}, parameters_);
  const LeftOutDrive first = leaveOneOut(drives_, parameters_, refine(drives_, parameters_))[0];
  for (std::size_t p = 0; p < kCount; ++p) {
    const auto i = static_cast<Eigen::Index>(p);
    // Rounds that begin elsewhere end within a hundredth of a deviation.
    EXPECT_NEAR(first.refined.values[i], others.values[i], 0.02 * std::sqrt(others.covariance(i, i)));
  }
}

TEST_F(LeaveOneOut, NeedsTwoDrives) {
  const Drives one{drives_[0]};
  EXPECT_TRUE(leaveOneOut(one, parameters_, refine(one, parameters_)).empty());
}

/// Dead reckoning is exact here, so a pose that nobody believes would be all of the error.
TEST_F(LeaveOneOut, OutliersAreNoEndsOfADrive) {
  SimulatedDrive simulated;
  simulated.laser_sigma = {0.0, 0.0};
  simulated.truth = truth_;
  const CalibratedDrive calibrated = calibrate(simulated, parameters_);
  CalibrationDrive drive;
  for (std::size_t i = 0; i < calibrated.drive.steps(); ++i) drive.add(calibrated.drive.step(i));
  for (DriveLaser laser : calibrated.drive.lasers()) {
    const bool last = laser.laser.stamp == calibrated.drive.lasers().back().laser.stamp;
    if (last) laser.laser.pose.x += 5.0;
    drive.add(laser);
  }
  const Refinement refined = refine({&drive}, parameters_);
  const Drift drift = endDrift(drive, parameters_, truth_, refined.residuals[0]);
  EXPECT_LT(drift.error, 0.002);  // 50 Hz steps of 19 m
}

TEST_F(LeaveOneOut, PartsOfADriveAddUp) {
  const Refinement refined = refine({drives_[2]}, parameters_);
  CalibrationDrive cut;
  for (std::size_t i = 0; i < drives_[2]->steps(); ++i) cut.add(drives_[2]->step(i));
  std::size_t i = 0;
  for (DriveLaser laser : drives_[2]->lasers()) {
    laser.jumped = ++i == 300;
    cut.add(laser);
  }
  const ParameterVector nominal = valuesOf(parameters_);
  const Drift whole = endDrift(*drives_[2], parameters_, nominal, refined.residuals[0]);
  const Drift parts = endDrift(cut, parameters_, nominal, refined.residuals[0]);
  EXPECT_NEAR(parts.distance, whole.distance, 0.25);  // one laser interval less
  EXPECT_NE(parts.error, whole.error);
}

}  // namespace
}  // namespace bs_car_odometry::calibration
