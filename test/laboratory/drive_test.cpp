#include "bs_car_odometry/laboratory/drive.hpp"

#include "cars.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace bs_car_odometry::laboratory {
namespace {

double endError(const OdometryConfiguration& configuration, const std::vector<Sample>& drive) {
  double error = 0.0;
  replay(configuration, drive, [&error](const Sample& sample, const OdometryUpdate& update) {
    error = std::hypot(update.estimate.pose.x - sample.truth.x, update.estimate.pose.y - sample.truth.y);
  });
  return error;
}

/// Drawn gains of a percent show; the same drive without them is exact to the sampling of the steering.
TEST(Record, drawsTheGainsWhenAsked) {
  const OdometryConfiguration configuration = cycabOdometry();
  DriveSettings settings = studyOf({configuration}, "fig4").drive;
  settings.noise.reset();
  settings.draw_gains.reset();
  EXPECT_LT(endError(configuration, record(configuration.vehicle, settings)), 1e-3);
  settings.draw_gains = SystematicNoise();
  EXPECT_GT(endError(configuration, record(configuration.vehicle, settings)), 1e-2);
}

TEST(Record, theSameSeedIsTheSameDrive) {
  const OdometryConfiguration configuration = cycabOdometry();
  DriveSettings settings = studyOf({configuration}, "fig4").drive;
  const std::vector<Sample> drive = record(configuration.vehicle, settings);
  const std::vector<Sample> again = record(configuration.vehicle, settings);
  settings.seed = 2;
  const std::vector<Sample> other = record(configuration.vehicle, settings);
  ASSERT_EQ(drive.size(), 751u);  // 15 s at 50 Hz, both ends
  EXPECT_EQ(drive.back().ticks.values, again.back().ticks.values);
  EXPECT_NE(drive.back().ticks.values, other.back().ticks.values);
}

TEST(Record, unknownScenariosAreRefused) {
  DriveSettings settings;
  settings.scenario = "eights";
  EXPECT_THROW(record(cycabOdometry().vehicle, settings), simulation::ScenarioError);
}

}  // namespace
}  // namespace bs_car_odometry::laboratory
