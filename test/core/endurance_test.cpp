// A covariance that lives long. $BS_CAR_ODOMETRY_DAYS says how many simulated days are driven;
// scripts/endurance asks for thirty.
#include "support/environment.hpp"
#include "support/figure.hpp"
#include "support/matchers.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/odometry_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <string>
#include <vector>

namespace bs_car_odometry {
namespace {

using namespace test_support;

constexpr long kStepsPerHour = 3600L * 100L;  // 100 Hz
const Duration kInterval = durationFromSeconds(0.01);

double daysToDrive() { return fromEnvironment("BS_CAR_ODOMETRY_DAYS", 1.0); }

OdometryEstimator makeEstimator(Uncertainty method) {
  OdometryConfiguration configuration;
  configuration.vehicle = cycab();
  configuration.options.uncertainty = method;
  return OdometryEstimator(configuration);
}

/// An eight that is driven again and again at 1 m/s, each loop in 20 s.
class Eight {
 public:
  const StepReadings& step(long i) const { return (i / 2000) % 2 == 0 ? left_ : right_; }

 private:
  StepReadings left_{consistentReadings(cycab(), 0.01, slaved(cycab(), 0.3))};
  StepReadings right_{consistentReadings(cycab(), 0.01, slaved(cycab(), -0.3))};
};

class Endurance : public testing::TestWithParam<Uncertainty> {};

TEST_P(Endurance, O3_ParkedForADayTheCovarianceStaysTheSame) {
  OdometryEstimator estimator = makeEstimator(GetParam());
  const Eight eight;
  for (long i = 0; i < 3000; ++i) ASSERT_TRUE(estimator.step(eight.step(i), kInterval));
  const OdometryEstimate before = estimator.estimate();
  StepReadings standing = eight.step(0);
  standing.travel = {};
  for (long i = 0; i < 24 * kStepsPerHour; ++i) estimator.step(standing, kInterval);
  EXPECT_EQ(estimator.estimate().pose.vector(), before.pose.vector());
  EXPECT_EQ(estimator.estimate().pose_covariance, before.pose_covariance);
}

TEST_P(Endurance, O2_SymmetricAndSemidefiniteAfterDaysOnTheRoad) {
  OdometryEstimator estimator = makeEstimator(GetParam());
  const Eight eight;
  const long hours = std::lround(24.0 * daysToDrive());
  long step = 0;
  for (long hour = 0; hour < hours; ++hour) {
    for (long i = 0; i < kStepsPerHour; ++i) estimator.step(eight.step(step++), kInterval);
    ASSERT_TRUE(isCovariance(estimator.estimate().pose_covariance)) << "after " << hour + 1 << " hours";
    ASSERT_TRUE(isCovariance(estimator.estimate().twist_covariance));
  }
  std::cout << "  after " << hours << " hours, standard deviations "
            << estimator.estimate().pose_covariance.diagonal().cwiseSqrt().transpose() << std::endl;
  recordFigure("a covariance in each of %ld hours at 100 Hz", hours);
}

INSTANTIATE_TEST_SUITE_P(Methods, Endurance,
                         testing::Values(Uncertainty::kFirstOrder, Uncertainty::kExactMoments,
                                         Uncertainty::kClosedForm, Uncertainty::kPaper2Simplified),
                         methodName);

}  // namespace
}  // namespace bs_car_odometry
