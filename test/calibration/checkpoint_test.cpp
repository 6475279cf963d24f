// A calibration that is ended in the middle goes on (docs/reliability.md, row C13).

#include "bs_car_odometry/calibration/checkpoint.hpp"
#include "bs_car_odometry/calibration/atomic_file.hpp"
#include "bs_car_odometry/simulation/random.hpp"
#include "car_with_laser.hpp"
#include "support/environment.hpp"
#include "support/figure.hpp"
#include "tools/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <sys/wait.h>
#include <unistd.h>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

namespace bs_car_odometry::calibration {
namespace {

using simulation::Command;
using ::testing::HasSubstr;
using tools::testing::errorOf;
using tools::testing::TemporaryFolder;

constexpr double kNow = 1.8e9;  // s, wall time
constexpr double kPeriod = 10.0;
constexpr double kRestart = 2.0;  // s until a node that was killed runs again
constexpr double kEnd = 200.0;

// scripts/kills asks for more.
const int kKills = static_cast<int>(fromEnvironment("BS_CAR_ODOMETRY_KILLS", 100.0));

CarSettings longDrive() {
  CarSettings settings;
  settings.scenario = scenarioNamed("slalom_eight");
  settings.seed = 17;
  return settings;
}

CalibrationMemory memoryAfter(double seconds) {
  const CarSettings settings = longDrive();
  Calibrator calibrator(settings.parameters);
  CarWithLaser(settings).driveUntil(seconds, calibrator);
  return calibrator.memory().value();
}

class Checkpoint : public ::testing::Test {
 protected:
  std::string path() const { return checkpointPath(folder_.file("gains.yaml")); }
  std::string text() const {
    std::ifstream file(path());
    return {std::istreambuf_iterator<char>(file), {}};
  }

  TemporaryFolder folder_;
  const Parameters parameters_{cycabWithLaser()};
};

TEST_F(Checkpoint, C13_readsBackAsItWasWritten) {
  EXPECT_EQ(path(), folder_.file("gains.yaml.checkpoint"));
  EXPECT_FALSE(readCheckpoint(path(), parameters_, kNow)) << "there is none yet";
  const CalibrationMemory memory = memoryAfter(20.0);
  writeCheckpoint(path(), memory, parameters_, kNow);
  const CalibrationMemory read = readCheckpoint(path(), parameters_, kNow + 3599.0).value();
  EXPECT_EQ(read.values, memory.values);
  EXPECT_EQ(read.covariance, memory.covariance);
  EXPECT_EQ(read.driven.distance, memory.driven.distance);
  EXPECT_EQ(read.driven.turn_rate_change, memory.driven.turn_rate_change);
  EXPECT_EQ(read.counts.used, memory.counts.used);
  EXPECT_EQ(read.span.begin, memory.span.begin);
  EXPECT_EQ(read.span.end, memory.span.end);
  removeCheckpoint(path());
  EXPECT_EQ(folder_.files(), 0u);
}

TEST_F(Checkpoint, C13_isOfThisCarAndOfThisHour) {
  writeCheckpoint(path(), memoryAfter(20.0), parameters_, kNow);
  EXPECT_THAT(errorOf([&] { readCheckpoint(path(), parameters_, kNow + 3601.0); }), HasSubstr("an hour"));
  EXPECT_THAT(errorOf([&] { readCheckpoint(path(), parameters_, kNow - 61.0); }), HasSubstr("future"));
  Parameters other = parameters_;
  other.vehicle.name = "other";
  EXPECT_THAT(errorOf([&] { readCheckpoint(path(), other, kNow); }), HasSubstr("another car"));
  other = parameters_;
  other.calibration.prior.k_b = 0.1;
  EXPECT_THAT(errorOf([&] { readCheckpoint(path(), other, kNow); }), HasSubstr("other parameters"));
  other = parameters_;
  other.vehicle.gains.rear.k_l = 1.01;
  EXPECT_THAT(errorOf([&] { readCheckpoint(path(), other, kNow); }), HasSubstr("other parameters"));
}

TEST_F(Checkpoint, C13_cutOrAlteredAnywhereItIsNotUsed) {
  writeCheckpoint(path(), memoryAfter(5.0), parameters_, kNow);
  const std::string whole = text();
  for (std::size_t i = 0; i < whole.size(); i += 7) {
    folder_.write("gains.yaml.checkpoint", whole.substr(0, i));
    EXPECT_THAT(errorOf([&] { readCheckpoint(path(), parameters_, kNow); }), HasSubstr("is not used"))
        << "cut at " << i;
    std::string altered = whole;
    altered[i] = static_cast<char>(altered[i] ^ 1);
    folder_.write("gains.yaml.checkpoint", altered);
    EXPECT_THAT(errorOf([&] { readCheckpoint(path(), parameters_, kNow); }), HasSubstr("is not used"))
        << "altered at " << i;
  }
}

/// Killed at a time, started again two seconds later from the checkpoint of the last ten seconds.
FilterEstimate interrupted(double time, const std::string& path, std::uint64_t& losses) {
  const CarSettings settings = longDrive();
  CarWithLaser car(settings);
  Calibrator killed(settings.parameters);
  for (double kept = kPeriod; kept <= time; kept += kPeriod) {
    car.driveUntil(kept, killed);
    if (const auto memory = killed.memory()) writeCheckpoint(path, *memory, settings.parameters, kNow);
  }
  car.driveUntil(time, killed);
  Calibrator lost(settings.parameters);
  car.driveUntil(time + kRestart, lost);
  Calibrator again(settings.parameters);
  if (const auto memory = readCheckpoint(path, settings.parameters, kNow)) {
    EXPECT_TRUE(again.resume(*memory));
  } else {
    ++losses;
  }
  car.driveUntil(kEnd, again);
  removeCheckpoint(path);
  return again.estimate();
}

TEST_F(Checkpoint, C13_howeverOftenKilledTheGainsAreThoseOfAnUninterruptedRun) {
  constexpr std::uint64_t kSeed = 19;
  std::cout << "seed " << kSeed << "\n";
  const CarSettings settings = longDrive();
  Calibrator calibrator(settings.parameters);
  CarWithLaser(settings).driveUntil(kEnd, calibrator);
  const FilterEstimate whole = calibrator.estimate();
  simulation::Random random(kSeed, 0);
  double farthest = 0.0;
  std::uint64_t losses = 0;
  for (int i = 0; i < kKills; ++i) {
    const double time = kEnd * random.uniform();
    const FilterEstimate found = interrupted(time, path(), losses);
    for (std::size_t k = 0; k < kCount; ++k) {
      const auto entry = static_cast<Eigen::Index>(k);
      if (!calibrator.estimated()[k]) continue;
      const double apart =
          std::abs(found.values[entry] - whole.values[entry]) / std::sqrt(whole.covariance(entry, entry));
      farthest = std::max(farthest, apart);
      EXPECT_LT(apart, 1.0) << parameterName(k) << ", killed at " << time << " s";
    }
  }
  std::cout << losses << " killed before the first checkpoint\n";
  recordFigure("%d kills: gains within %.2f standard deviations of an uninterrupted run's", kKills, farthest);
}

/// Writes checkpoints as fast as it can until it is killed.
/// @param begun  where it says that the first one has been written
[[noreturn]] void writeForEver(const std::string& path, const Parameters& parameters,
                               CalibrationMemory memory, int begun) {
  for (bool first = true;; first = false) {
    memory.driven.distance += 1.0;
    writeCheckpoint(path, memory, parameters, kNow);
    if (first && ::write(begun, "1", 1) != 1) std::abort();
  }
}

TEST_F(Checkpoint, C13_aProcessKilledWhileItWritesLeavesAWholeOne) {
  const CalibrationMemory memory = memoryAfter(5.0);
  for (int i = 0; i < kKills; ++i) {
    removeCheckpoint(path());
    std::array<int, 2> begun{};
    ASSERT_EQ(::pipe(begun.data()), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) writeForEver(path(), parameters_, memory, begun[1]);
    ::close(begun[1]);
    char byte = 0;
    ASSERT_EQ(::read(begun[0], &byte, 1), 1);
    ::close(begun[0]);
    ::usleep(static_cast<useconds_t>(97 * (i % 100)));  // somewhere in its writing, each time elsewhere
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const auto read = readCheckpoint(path(), parameters_, kNow);
    ASSERT_TRUE(read);
    EXPECT_GT(read->driven.distance, memory.driven.distance);
  }
}

}  // namespace
}  // namespace bs_car_odometry::calibration
