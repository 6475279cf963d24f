#pragma once

#include "noise_fit.hpp"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// The end of a run against what was found without it.
struct EndJudgement {
  Eigen::Vector3d error;       ///< truth less odometry with the gains found: x, y, yaw [m, m, rad]
  Eigen::Matrix3d covariance;  ///< Sigma_total, and the truth's own errors
  double d2{0.0};              ///< squared Mahalanobis distance of the end position
  double nees{0.0};            ///< (N1) of the end pose
};

/// One run, judged twice; poses in the frame of the run's first true pose.
struct JudgedRun {
  std::string name;
  std::string wheels;
  std::string recording;
  double distance{0.0};  ///< [m]
  EndJudgement without_run;
  EndJudgement without_recording;
};

/// Runs of one recording that drove the same path: how their ends scatter, and how they should.
struct RepeatedPath {
  std::vector<std::string> runs;
  Eigen::Vector3d measured_std;  ///< of the end's error about its mean: x, y, yaw [m, m, rad]
  Eigen::Vector3d
      predicted_std;       ///< by the noise of the path and of the truth; what is constant is not in it
  double chi_square{0.0};  ///< of the scatter of the positions, expected to be
  double degrees_of_freedom{0.0};
};

struct RecordedConsistency {
  NoiseFit fit;  ///< over all runs
  std::vector<JudgedRun> runs;
  std::vector<RepeatedPath> repeated;
};

/// Share of the runs with d2 below a limit, [0, 1].
double shareBelow(double limit, const std::vector<JudgedRun>& runs, EndJudgement JudgedRun::*judgement);

/// Judges every run by gains and noise found on the others (docs/model.md, R4): first without the run, then
/// without its whole recording.
/// @throws InputError
RecordedConsistency judgeRecordedRuns(const std::vector<RecordedRun>& runs, const Parameters& parameters,
                                      const NoiseFitSettings& settings);

/// The runs that travelled farther than `distance` [m, mean of the wheels].
std::vector<RecordedRun> runsLongerThan(double distance, std::vector<RecordedRun> runs,
                                        const Parameters& parameters);

}  // namespace bs_car_odometry::tools
