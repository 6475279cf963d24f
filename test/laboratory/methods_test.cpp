// Exact moments and particles against simulated drives with drawn parameters, Gaussian and uniform, however
// far the heading goes.
#include "cars.hpp"

#include "bs_car_odometry/laboratory/chi_square.hpp"

#include "support/figure.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <string>
#include <tuple>

namespace bs_car_odometry::laboratory {
namespace {

/// The same standard deviations, uniform.
SystematicNoise uniform(const SystematicNoise& noise) {
  const auto flat = [](const Distribution& d) { return Distribution::uniform(std::sqrt(3.0) * d.std()); };
  return {flat(noise.k_r), flat(noise.k_l), flat(noise.k_b), flat(noise.steering_offset)};
}

using Case = std::tuple<const char*, bool>;  ///< scenario, uniform or Gaussian

class Methods : public testing::TestWithParam<Case> {
 protected:
  StudySettings study(Uncertainty method, std::size_t drives) const {
    const auto [scenario, is_uniform] = GetParam();
    std::vector<OdometryConfiguration> odometries;
    for (const AxleSelection axles : {AxleSelection::kBoth, AxleSelection::kRear}) {
      odometries.push_back(cycabOdometry(axles));
      odometries.back().options.uncertainty = method;
      odometries.back().options.particles.count = 1000;
      SystematicNoise& systematic = odometries.back().noise.systematic;
      if (is_uniform) systematic = uniform(systematic);
    }
    StudySettings study = studyOf(odometries, scenario);
    study.drives = drives;
    study.places = 4;
    std::cout << drives << " drives, seeds from " << study.drive.seed << " on" << std::endl;
    return study;
  }
};

class ExactMoments : public Methods {};

/// Mean NEES in (x, y, yaw), which no bend of the cloud excuses. A bent cloud has heavier tails than a
/// Gaussian one: on the long loops the mean of 1,000 drives has a standard error of 0.2 and more, where
/// chi-squares have 0.08; so the interval of the latter is doubled. The circle is not here: with both axles
/// it has 3.6 (docs/model.md, 5.7).
TEST_P(ExactMoments, O4_areNeverOverconfident) {
  constexpr std::size_t kDrives = 300;
  double largest = 0.0;
  for (const ConsistencyOverDistance& places : studyConsistency(study(Uncertainty::kExactMoments, kDrives))) {
    const Consistency& end = places.back();
    std::cout << "  heading " << end.sigma().z() << " rad, mean NEES " << end.meanPlainNees() << std::endl;
    EXPECT_LE(end.meanPlainNees(), 3.0 + 2.0 * (meanInterval(3.0, kDrives).high - 3.0));
    largest = std::max(largest, end.meanPlainNees());
  }
  recordFigure("exact moments: largest mean NEES %.2f of 3 dimensions", largest);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, ExactMoments,
                         testing::Combine(testing::Values("fig4", "slalom_eight", "straight", "rectangle",
                                                          "square_loop"),
                                          testing::Bool()));

class Particles : public Methods {};

/// As many true poses within each region as the method has particles there.
TEST_P(Particles, areWhereTheTruthsAre) {
  constexpr std::size_t kDrives = 150;
  for (const ConsistencyOverDistance& places : studyConsistency(study(Uncertainty::kMonteCarlo, kDrives))) {
    const Consistency& end = places.back();
    for (std::size_t k = 0; k < 3; ++k) {
      const double expected = end.expectedPlainRegionCoverage()[k];
      // 4 standard deviations of a share of so many drives, and one drive more where the share is next to 1.
      const double deviation = std::sqrt(expected * (1.0 - expected) / static_cast<double>(kDrives));
      EXPECT_NEAR(end.plainRegionCoverage()[k], expected, 4.0 * deviation + 1.0 / kDrives)
          << k + 1 << " sigma";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, Particles,
                         testing::Combine(testing::Values("fig4", "circle"), testing::Bool()));

}  // namespace
}  // namespace bs_car_odometry::laboratory
