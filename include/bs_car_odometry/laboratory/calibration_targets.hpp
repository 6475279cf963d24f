#pragma once

#include "bs_car_odometry/laboratory/calibration_study.hpp"

#include <string>
#include <vector>

namespace bs_car_odometry::laboratory {

/// What is asked of the calibration (docs/calibration.md, 5).
enum class CalibrationTarget {
  kEfficiency = 1,  ///< errors as small as the bound
  kConsistency,     ///< covariances that say how large the errors are
  kConvergence,     ///< how soon
  kOutliers,        ///< laser poses that are wrong altogether
  kWrongGains,      ///< a prior that does not hold
  kExactData,       ///< no bias without noise
  kTimeOffset,      ///< found, and noticed where it is not looked for
  kStraightRun,     ///< what the drive does not show keeps its prior
  kDeadReckoning,   ///< the odometry afterwards
};

const std::vector<CalibrationTarget>& allCalibrationTargets();

/// One figure against what is asked for.
struct TargetRow {
  CalibrationTarget target;
  std::string drive;
  std::string axles;
  std::string what;
  double measured{0.0};
  std::string wanted;
  bool met{false};
};

/// @param study  its cases are left out of account
/// @return the rows in the order of the targets
std::vector<TargetRow> judgeCalibration(const CalibrationStudySettings& study,
                                        const std::vector<CalibrationTarget>& targets);

}  // namespace bs_car_odometry::laboratory
