// The calibration over hundreds of simulated drives against what is asked of it (docs/calibration.md, 5).
#include "bs_car_odometry/laboratory/calibration_targets.hpp"

#include <gtest/gtest.h>

#include <iostream>
#include <string>

namespace bs_car_odometry::laboratory {
namespace {

CalibrationStudySettings cycabStudy(std::size_t runs) {
  CalibrationStudySettings study;
  study.runs = runs;
  Vehicle& vehicle = study.configured.vehicle;
  vehicle.name = "cycab";
  vehicle.wheelbase = 1.2;
  vehicle.track = {1.2, 1.2};
  for (const Wheel wheel : kAllWheels) vehicle.metres_per_tick[wheel] = 1e-4;
  return study;
}

/// The limits stand with the targets; their reasons in docs/calibration.md.
void expectMet(CalibrationTarget target, std::size_t runs) {
  const CalibrationStudySettings study = cycabStudy(runs);
  std::cout << "seeds " << study.seed << " to " << study.seed + runs - 1 << "\n";
  const std::vector<TargetRow> rows = judgeCalibration(study, {target});
  ASSERT_FALSE(rows.empty());
  for (const TargetRow& row : rows) {
    std::cout << row.drive << ", " << row.axles << ": " << row.what << " " << row.measured << "\n";
    EXPECT_TRUE(row.met) << row.drive << ", " << row.axles << ": " << row.what << " " << row.measured
                         << ", wanted " << row.wanted;
  }
}

TEST(CalibrationTargets, T1ErrorsAsSmallAsTheBound) { expectMet(CalibrationTarget::kEfficiency, 500); }
TEST(CalibrationTargets, T2Consistency) { expectMet(CalibrationTarget::kConsistency, 200); }
TEST(CalibrationTargets, T3Convergence) { expectMet(CalibrationTarget::kConvergence, 200); }
TEST(CalibrationTargets, T4Outliers) { expectMet(CalibrationTarget::kOutliers, 1000); }
TEST(CalibrationTargets, T5WrongGains) { expectMet(CalibrationTarget::kWrongGains, 1000); }
TEST(CalibrationTargets, T6NoBiasWithoutNoise) { expectMet(CalibrationTarget::kExactData, 2); }
TEST(CalibrationTargets, T7TimeOffset) { expectMet(CalibrationTarget::kTimeOffset, 200); }
TEST(CalibrationTargets, T8StraightRun) { expectMet(CalibrationTarget::kStraightRun, 200); }
TEST(CalibrationTargets, T9DeadReckoning) { expectMet(CalibrationTarget::kDeadReckoning, 500); }

}  // namespace
}  // namespace bs_car_odometry::laboratory
