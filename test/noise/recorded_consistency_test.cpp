// Ends of drives judged by gains and noise found on the others: simulated drives, and recorded ones.

#include "../../src/tools/recorded_consistency.hpp"

#include "../../src/tools/recorded_folder.hpp"
#include "simulated_run.hpp"
#include "support/figure.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>

namespace bs_car_odometry::tools::testing {
namespace {

double meanOf(const std::vector<JudgedRun>& runs, EndJudgement JudgedRun::*judgement,
              double EndJudgement::*value) {
  double mean = 0.0;
  for (const JudgedRun& run : runs) mean += (run.*judgement).*value / static_cast<double>(runs.size());
  return mean;
}

/// Gains differ from drive to drive; each drive is a recording, so both ways of leaving out are the same.
TEST(RecordedConsistency, simulatedDrivesAreJudgedRight) {
  const Parameters parameters = cycab(AxleSelection::kRear);
  SimulatedDriveSettings drive;
  drive.rate = 20.0;
  drive.draw_gains = true;
  NoiseFitSettings settings;
  settings.errors.truth_position = settings.errors.truth_yaw = 1e-5;
  // Gains that differ more would bend the paths beyond first order (docs/model.md, 8.3).
  Parameters drawn = parameters;
  drawn.noise.systematic = {0.002, 0.002, 0.005, 0.0};
  const RecordedConsistency judged =
      judgeRecordedRuns(simulatedRuns(drawn, drive, 100, 24), parameters, settings);
  ASSERT_EQ(judged.runs.size(), 24u);
  // 99.9 % intervals of the mean of 24 chi-squares with 2 and with 3 degrees of freedom. Noise found from 23
  // drives is known to a few percent, which is little beside them.
  EXPECT_GT(meanOf(judged.runs, &JudgedRun::without_run, &EndJudgement::d2), 0.9);
  EXPECT_LT(meanOf(judged.runs, &JudgedRun::without_run, &EndJudgement::d2), 3.65);
  EXPECT_GT(meanOf(judged.runs, &JudgedRun::without_run, &EndJudgement::nees), 1.6);
  EXPECT_LT(meanOf(judged.runs, &JudgedRun::without_run, &EndJudgement::nees), 4.95);
  for (const JudgedRun& run : judged.runs) EXPECT_EQ(run.without_run.d2, run.without_recording.d2);
  EXPECT_TRUE(judged.repeated.empty()) << "every drive is a recording";
}

/// The same path driven again within one recording scatters as its noise says.
TEST(RecordedConsistency, repeatedPathsScatterAsPredicted) {
  const Parameters parameters = cycab(AxleSelection::kRear);
  SimulatedDriveSettings drive;
  drive.rate = 20.0;
  std::vector<RecordedRun> runs = simulatedRuns(parameters, drive, 200, 12);
  for (std::size_t i = 0; i < runs.size(); ++i) runs[i].recording = i < 6 ? "morning" : "evening";
  NoiseFitSettings settings;
  settings.errors.truth_position = settings.errors.truth_yaw = 1e-5;
  const RecordedConsistency judged = judgeRecordedRuns(runs, parameters, settings);
  ASSERT_EQ(judged.repeated.size(), 2u);
  for (const RepeatedPath& path : judged.repeated) {
    EXPECT_EQ(path.runs.size(), 6u);
    EXPECT_EQ(path.degrees_of_freedom, 10.0);
    // 99.9 % interval of a chi-square with 10 degrees of freedom.
    EXPECT_GT(path.chi_square, 1.2);
    EXPECT_LT(path.chi_square, 31.4);
  }
}

/// The recordings, where there are any.
class RecordedDrives : public ::testing::Test {
 protected:
  static std::string folder() {
    const char* const named = std::getenv("BS_CAR_ODOMETRY_DATA");
    const std::string data =
        named != nullptr && *named != '\0' ? named : BS_CAR_ODOMETRY_SOURCE "/../shared/data";
    return data + "/optiodom_diff";
  }

  void SetUp() override {
    if (!std::filesystem::is_directory(folder())) GTEST_SKIP() << "no recordings in " << folder();
    const RecordedFolderSettings set = readRecordedFolderSettings(
        BS_CAR_ODOMETRY_SOURCE "/test/evaluation/recordings.yaml", "optiodom_diff");
    parameters_ = loadVehicle({set.vehicle}, {});
    runs_ = runsLongerThan(1.0, readRecordedFolder(folder(), set), parameters_);
  }

  static double largest(const std::vector<JudgedRun>& runs, EndJudgement JudgedRun::*judgement) {
    double d2 = 0.0;
    for (const JudgedRun& run : runs) d2 = std::max(d2, (run.*judgement).d2);
    return d2;
  }

  static void print(const char* what, const std::vector<JudgedRun>& runs,
                    EndJudgement JudgedRun::*judgement) {
    std::cout << what << " held out: largest d2 " << largest(runs, judgement) << ", below 11.83 "
              << shareBelow(11.83, runs, judgement) << ", below 9 " << shareBelow(9.0, runs, judgement)
              << ", below 1 " << shareBelow(1.0, runs, judgement) << ", mean "
              << meanOf(runs, judgement, &EndJudgement::d2) << ", mean NEES "
              << meanOf(runs, judgement, &EndJudgement::nees) << "\n";
  }

  static NoiseFitSettings settings() {
    NoiseFitSettings settings;
    settings.errors.truth_position = 0.003;  // m, as the recordings' motion capture is used here
    return settings;
  }

  /// Judged once for all tests.
  const RecordedConsistency& judged() const {
    static const RecordedConsistency kJudged = judgeRecordedRuns(runs_, parameters_, settings());
    return kJudged;
  }

  /// 11.83 and 9 are the 3 sigma regions of two and of one degree of freedom. Of a perfect covariance 39 %
  /// would lie below 1: many more would show inflation.
  static void expectTargets(const RecordedConsistency& judged) {
    print("one run", judged.runs, &JudgedRun::without_run);
    print("one recording", judged.runs, &JudgedRun::without_recording);
    EXPECT_LT(largest(judged.runs, &JudgedRun::without_run), 11.83);
    EXPECT_GE(shareBelow(9.0, judged.runs, &JudgedRun::without_run), 0.96);
    EXPECT_GE(shareBelow(1.0, judged.runs, &JudgedRun::without_run), 0.30);
    EXPECT_LE(shareBelow(1.0, judged.runs, &JudgedRun::without_run), 0.75);

    EXPECT_GE(shareBelow(11.83, judged.runs, &JudgedRun::without_recording), 0.98);
    EXPECT_GE(shareBelow(1.0, judged.runs, &JudgedRun::without_recording), 0.20);
    EXPECT_LE(shareBelow(1.0, judged.runs, &JudgedRun::without_recording), 0.60);
  }

  Parameters parameters_;
  std::vector<RecordedRun> runs_;
};

/// 11.83 and 9 are the 3 sigma regions of two and of one degree of freedom. Of a perfect covariance 39 %
/// would lie below 1: many more would show inflation.
TEST_F(RecordedDrives, O4_endsAreWhereTheCovarianceSays) {
  ASSERT_EQ(runs_.size(), 46u);
  for (const FoundNoise& noise : judged().fit.noise)
    std::cout << noise.name << ": " << noise.value << " +/- " << noise.std << "\n";
  EXPECT_EQ(judged().fit.recordings, 11u);
  expectTargets(judged());
  recordFigure("46 recorded runs, noise of the other recordings: largest squared Mahalanobis distance %.1f",
               largest(judged().runs, &JudgedRun::without_recording));
}

/// What is found does not hang on where the paths are compared, nor on the heading of the first true pose.
TEST_F(RecordedDrives, theTargetsHoldForOtherSettings) {
  const std::pair<double, double> spacings_and_headings[] = {{0.5, 0.003}, {2.0, 0.01}};
  for (const auto& [spacing, truth_yaw] : spacings_and_headings) {
    NoiseFitSettings other = settings();
    other.errors.truth_yaw = truth_yaw;
    other.errors.spacing = spacing;
    std::cout << "places every " << spacing << " m, first heading to " << truth_yaw << " rad\n";
    expectTargets(judgeRecordedRuns(runs_, parameters_, other));
  }
}

/// Straight lines, squares and circles driven again; no run is left out without a word.
TEST_F(RecordedDrives, repeatedPathsAreFound) {
  EXPECT_EQ(judged().repeated.size(), 9u);
  double chi_square = 0.0;
  double degrees_of_freedom = 0.0;
  for (const RepeatedPath& path : judged().repeated) {
    std::cout << path.runs.front() << ", " << path.runs.size() << " runs: " << path.measured_std.transpose()
              << " measured, " << path.predicted_std.transpose() << " predicted\n";
    chi_square += path.chi_square;
    degrees_of_freedom += path.degrees_of_freedom;
  }
  EXPECT_EQ(degrees_of_freedom, 52.0);
  // Repeats scatter less than predicted: part of what the model calls noise is the same each time the same
  // path is driven. They must never scatter more (99.9 % of a chi-square with 52 degrees of freedom).
  EXPECT_LT(chi_square, 89.3);
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
