// fitNoise() over simulated drives whose noise and gains are known.

#include "../../src/tools/noise_fit.hpp"

#include "simulated_run.hpp"
#include "tools/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>

#include <cmath>

namespace bs_car_odometry::tools::testing {
namespace {

// The simulated truth is exact; a truth without any error would leave nothing to divide by.
constexpr double kExact = 1e-5;

NoiseFitSettings settingsFor(const std::vector<std::string>& noise) {
  NoiseFitSettings settings;
  settings.errors.truth_position = settings.errors.truth_yaw = kExact;
  settings.noise = noise;
  return settings;
}

SimulatedDriveSettings fig4() {
  SimulatedDriveSettings settings;
  settings.scenario = "fig4";
  settings.rate = 20.0;
  return settings;
}

double valueOf(const NoiseFit& fit, const std::string& name) {
  for (const FoundNoise& noise : fit.noise)
    if (noise.name == name) return noise.value;
  ADD_FAILURE() << name << " was not sought";
  return 0.0;
}

double stdOf(const NoiseFit& fit, const std::string& name) {
  for (const FoundNoise& noise : fit.noise)
    if (noise.name == name) return noise.std;
  return 0.0;
}

/// Twenty fits of eight drives each, so that the standard errors are judged too. The simulated gains are
/// (1.02, 0.99, 1.03) in every drive.
TEST(NoiseFit, findsNoiseAndGainsWithinItsOwnStandardErrors) {
  constexpr int kFits = 20;
  const Parameters parameters = cycab(AxleSelection::kRear);
  const Eigen::Vector3d truth(1.02, 0.99, 1.03);
  double noise_squares = 0.0;
  double noise_sum = 0.0;
  double gain_squares = 0.0;
  for (std::uint64_t i = 0; i < kFits; ++i) {
    const NoiseFit fit =
        fitNoise(simulatedRuns(parameters, fig4(), 1 + 8 * i, 8), parameters, settingsFor({"noise/wheel"}));
    const double z = (valueOf(fit, "noise/wheel") - 0.005) / stdOf(fit, "noise/wheel");
    noise_sum += z / kFits;
    noise_squares += z * z / kFits;
    const Eigen::Vector3d error = fit.gains.at(0).value - truth;
    gain_squares += error.dot(fit.gains[0].covariance.llt().solve(error)) / kFits;
  }
  // 99.9 % intervals of the mean of 20 standard normal draws, of their squares (chi-square of 20 over 20) and
  // of 20 chi-squares of three degrees of freedom (chi-square of 60 over 20).
  EXPECT_LT(std::abs(noise_sum), 3.29 / std::sqrt(kFits));
  EXPECT_GT(noise_squares, 0.27);
  EXPECT_LT(noise_squares, 2.4);
  EXPECT_GT(gain_squares, 1.5);
  EXPECT_LT(gain_squares, 5.2);
}

/// Four wheels: three sources of noise at once, told apart by positions and headings.
TEST(NoiseFit, findsSeveralNoisesOfACarWithFourWheels) {
  const Parameters parameters = cycab(AxleSelection::kBoth);
  NoiseFitSettings settings = settingsFor({"noise/wheel", "noise/steering/std", "noise/lateral"});
  settings.errors.headings = true;
  const NoiseFit fit = fitNoise(simulatedRuns(parameters, fig4(), 1000, 30), parameters, settings);
  // 3.9 standard errors are exceeded once in 10,000 fits.
  EXPECT_NEAR(valueOf(fit, "noise/wheel"), 0.005, 3.9 * stdOf(fit, "noise/wheel"));
  EXPECT_NEAR(valueOf(fit, "noise/steering/std"), 0.003, 3.9 * stdOf(fit, "noise/steering/std"));
  EXPECT_NEAR(valueOf(fit, "noise/lateral"), 0.0005, 3.9 * stdOf(fit, "noise/lateral"));
  // And they are known well enough for that to say something.
  EXPECT_LT(stdOf(fit, "noise/wheel"), 0.05 * 0.005);
  EXPECT_LT(stdOf(fit, "noise/steering/std"), 0.1 * 0.003);
  EXPECT_LT(stdOf(fit, "noise/lateral"), 0.2 * 0.0005);
  EXPECT_EQ(fit.gain_names.size(), 6u);
}

/// Every drive with gains of its own, drawn from noise/systematic.
TEST(NoiseFit, findsHowRecordingsDiffer) {
  const Parameters parameters = cycab(AxleSelection::kRear);
  SimulatedDriveSettings drive = fig4();
  drive.draw_gains = true;
  const NoiseFit fit = fitNoise(simulatedRuns(parameters, drive, 2000, 30), parameters, settingsFor({}));
  const std::vector<std::pair<std::string, double>> truth{{"noise/wheel", 0.005},
                                                          {"noise/systematic/k_r", 0.01},
                                                          {"noise/systematic/k_l", 0.01},
                                                          {"noise/systematic/k_b", 0.02}};
  for (const auto& [name, value] : truth) {
    EXPECT_NEAR(valueOf(fit, name), value, 3.9 * stdOf(fit, name)) << name;
    EXPECT_LT(stdOf(fit, name), 0.25 * value) << name;
  }
  EXPECT_EQ(fit.recordings, 30u);
  // For another drive: the differences between recordings, and little beyond, 30 of them having been seen.
  for (const auto& [name, value] : fit.next_drive)
    EXPECT_NEAR(value, valueOf(fit, name), 0.1 * value) << name;
}

/// The same draws when three runs belong to a recording: runs of one recording share them.
TEST(NoiseFit, runsOfOneRecordingShareTheirGains) {
  const Parameters parameters = cycab(AxleSelection::kRear);
  std::vector<RecordedRun> runs;
  for (std::uint64_t recording = 0; recording < 12; ++recording) {
    Parameters driven = parameters;
    SimulatedDriveSettings settings = fig4();
    settings.draw_gains = true;
    settings.seed = 3000 + recording;
    driven.vehicle.gains.rear =
        SimulatedDrive(parameters, settings, Time(durationFromSeconds(1e9))).truth().gains.rear;
    // The simulator multiplies the gains by (1.02, 0.99, 1.03), the same for all.
    for (RecordedRun& run : simulatedRuns(driven, fig4(), 4000 + 3 * recording, 3)) {
      run.recording = std::to_string(recording);
      runs.push_back(run);
    }
  }
  const NoiseFit fit = fitNoise(runs, parameters, settingsFor({}));
  EXPECT_EQ(fit.recordings, 12u);
  EXPECT_NEAR(valueOf(fit, "noise/wheel"), 0.005, 3.9 * stdOf(fit, "noise/wheel"));
  EXPECT_NEAR(valueOf(fit, "noise/systematic/k_r"), 0.01, 3.9 * stdOf(fit, "noise/systematic/k_r"));
  EXPECT_NEAR(valueOf(fit, "noise/systematic/k_l"), 0.01, 3.9 * stdOf(fit, "noise/systematic/k_l"));
  EXPECT_NEAR(valueOf(fit, "noise/systematic/k_b"), 0.02, 3.9 * stdOf(fit, "noise/systematic/k_b"));
}

TEST(NoiseFit, wheelsOfTheirOwnHaveTheirOwnGains) {
  const Parameters parameters = cycab(AxleSelection::kRear);
  Parameters worn = parameters;
  worn.vehicle.gains.rear = {0.98, 0.98, 1.0};
  std::vector<RecordedRun> runs = simulatedRuns(parameters, fig4(), 5000, 6);
  for (RecordedRun& run : simulatedRuns(worn, fig4(), 5100, 6)) {
    run.wheels = "worn";
    runs.push_back(run);
  }
  const NoiseFit fit = fitNoise(runs, parameters, settingsFor({"noise/wheel"}));
  ASSERT_EQ(fit.gains.size(), 2u);
  EXPECT_EQ(fit.gains[1].wheels, "worn");
  EXPECT_NEAR(valueOf(fit, "noise/wheel"), 0.005, 3.9 * stdOf(fit, "noise/wheel"));
  const Eigen::Vector3d worn_truth(1.02 * 0.98, 0.99 * 0.98, 1.03);
  for (Eigen::Index j = 0; j < 3; ++j) {
    const double std = std::sqrt(fit.gains[1].covariance(j, j));
    EXPECT_NEAR(fit.gains[1].value[j], worn_truth[j], 3.9 * std) << j;
    EXPECT_LT(std, 0.004);
  }
}

/// A truth far worse than the odometry: whatever noise the wheels have, it cannot be seen.
TEST(NoiseFit, findsNothingWhereThereIsNothingToSee) {
  const Parameters parameters = cycab(AxleSelection::kRear);
  SimulatedDriveSettings drive = fig4();
  drive.noise_free = true;
  const NoiseFit fit = fitNoise(simulatedRuns(parameters, drive, 6000, 3), parameters, [] {
    NoiseFitSettings settings = settingsFor({"noise/wheel"});
    settings.errors.truth_position = 0.02;
    return settings;
  }());
  EXPECT_EQ(valueOf(fit, "noise/wheel"), 0.0);
  EXPECT_EQ(stdOf(fit, "noise/wheel"), 0.0);
}

TEST(NoiseFit, saysWhatItCannotFind) {
  const Parameters parameters = cycab(AxleSelection::kRear);
  const std::vector<RecordedRun> runs = simulatedRuns(parameters, fig4(), 7000, 1);
  const auto error = [&](const std::string& name) {
    return errorOf([&] { fitNoise(runs, parameters, settingsFor({name})); });
  };
  EXPECT_THAT(error("noise/wheels"), ::testing::HasSubstr("noise/wheel, noise/steering/std"));
  EXPECT_THAT(error("noise/systematic/steering_offset"), ::testing::HasSubstr("calibration/estimate"));
  EXPECT_THROW(fitNoise({}, parameters, settingsFor({})), InputError);
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
