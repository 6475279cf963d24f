// Noise grows with distance, so a covariance does not depend on how often the sensors are read.
#include "cars.hpp"
#include "drive.hpp"
#include "support/figure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace bs_car_odometry::drives {
namespace {

/// A tenth of a millimetre a tick, as an encoder has it: rounding must not matter either.
constexpr double kTick = 1e-4;

Eigen::Matrix3d endCovariance(const OdometryConfiguration& configuration, const char* scenario, double rate) {
  DriveSettings settings;
  settings.scenario = scenario;
  settings.rate = rate;
  return endOf(configuration, record(configuration.vehicle, settings)).pose_covariance;
}

/// Standard deviations within 1 %, covariances within 2 % of the product of their standard deviations.
/// @return the largest relative difference of a standard deviation
double expectAlike(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  const Eigen::Vector3d sigma = b.diagonal().cwiseSqrt();
  double largest = 0.0;
  for (Eigen::Index i = 0; i < 3; ++i) {
    EXPECT_NEAR(std::sqrt(a(i, i)), sigma(i), 0.01 * sigma(i)) << "component " << i;
    if (sigma(i) > 0.0) largest = std::max(largest, std::abs(std::sqrt(a(i, i)) / sigma(i) - 1.0));
    for (Eigen::Index j = 0; j < 3; ++j)
      EXPECT_NEAR(a(i, j), b(i, j), 0.02 * sigma(i) * sigma(j)) << i << ", " << j;
  }
  return largest;
}

void compareRates(bool systematic) {
  double worst = 0.0;
  for (const AxleGeometry geometry : {AxleGeometry::kAckermann, AxleGeometry::kPivot})
    for (const char* scenario : {"circle", "fig4", "slalom_eight"})
      for (const AxleSelection axles : {AxleSelection::kBoth, AxleSelection::kFront, AxleSelection::kRear}) {
        SCOPED_TRACE(std::string(scenario) + ", " + name(geometry) + ", axles " + name(axles));
        OdometryConfiguration configuration = odometryOf(cycab(geometry, kTick), axles);
        if (!systematic) configuration.noise.systematic = {0.0, 0.0, 0.0, 0.0};
        worst = std::max(worst, expectAlike(endCovariance(configuration, scenario, 10.0),
                                            endCovariance(configuration, scenario, 200.0)));
      }
  recordFigure("10 and 200 Hz: standard deviations differ by %.2f %% at most", 100.0 * worst);
}

TEST(MessageRate, O3_leavesTheCovarianceOfTheNoiseAsItIs) { compareRates(false); }

TEST(MessageRate, O3_leavesTheTotalCovarianceAsItIs) { compareRates(true); }

/// Beside the wheels' noise the others hardly show, so each alone; with one axle, where none acts as a
/// weight.
TEST(MessageRate, O3_leavesTheCovarianceOfEachSourceAsItIs) {
  const auto only = [](double wheel, double steering, double lateral, double rear_law) {
    return NoiseModel{wheel, {steering, 0.1}, lateral, rear_law, {0.0, 0.0, 0.0, 0.0}};
  };
  for (const NoiseModel& noise : {only(5e-3, 0.0, 0.0, 0.0), only(0.0, 3e-3, 0.0, 0.0),
                                  only(0.0, 0.0, 5e-4, 0.0), only(0.0, 0.0, 0.0, 1e-3)})
    for (const char* scenario : {"circle", "fig4", "slalom_eight"}) {
      SCOPED_TRACE(std::string(scenario) + ", wheel " + std::to_string(noise.wheel.std()) + ", steering " +
                   std::to_string(noise.steering.angle.std()) + ", lateral " +
                   std::to_string(noise.lateral.std()));
      OdometryConfiguration configuration =
          odometryOf(cycab(AxleGeometry::kAckermann, kTick), AxleSelection::kRear);
      configuration.noise = noise;
      expectAlike(endCovariance(configuration, scenario, 10.0),
                  endCovariance(configuration, scenario, 200.0));
    }
}

}  // namespace
}  // namespace bs_car_odometry::drives
