#include "bs_car_odometry/laboratory/consistency.hpp"

#include "bs_car_odometry/laboratory/chi_square.hpp"
#include "cars.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace bs_car_odometry::laboratory {
namespace {

Judgement judgementWith(double nees, const Eigen::Vector3d& error) {
  Judgement judgement;
  judgement.distance = 10.0;
  judgement.error = error;
  judgement.variance << 0.04, 0.01, 0.0001;
  judgement.nees = nees;
  judgement.plain_nees = 2.0 * nees;
  judgement.twist_nees = 3.0;
  judgement.twists = 5;
  return judgement;
}

TEST(Consistency, meansAndShares) {
  Consistency consistency;
  consistency.add(judgementWith(1.0, {0.1, 0.0, 0.0}));      // 0.5 sigma in x
  consistency.add(judgementWith(5.0, {-0.3, 0.05, 0.0}));    // 1.5 sigma in x
  consistency.add(judgementWith(9.0, {0.5, -0.05, 0.025}));  // 2.5 sigma in x and yaw
  consistency.add(judgementWith(20.0, {0.7, 0.0, 0.0}));     // 3.5 sigma in x
  EXPECT_EQ(consistency.drives(), 4u);
  EXPECT_DOUBLE_EQ(consistency.distance(), 10.0);
  EXPECT_DOUBLE_EQ(consistency.meanNees(), 8.75);
  EXPECT_DOUBLE_EQ(consistency.meanPlainNees(), 17.5);
  EXPECT_DOUBLE_EQ(consistency.meanError().x(), 0.25);
  EXPECT_DOUBLE_EQ(consistency.sigma().x(), 0.2);
  // Sample variance of 0.1, -0.3, 0.5, 0.7.
  EXPECT_NEAR(consistency.errorCovariance()(0, 0), 0.59 / 3.0, 1e-12);
  EXPECT_EQ(consistency.componentCoverage(0), (std::array<double, 3>{0.25, 0.5, 0.75}));
  EXPECT_EQ(consistency.componentCoverage(2), (std::array<double, 3>{0.75, 0.75, 1.0}));
  // Regions end at 3.53, 8.02 and 14.16.
  EXPECT_EQ(consistency.regionCoverage(), (std::array<double, 3>{0.25, 0.5, 0.75}));
  EXPECT_EQ(consistency.plainRegionCoverage(), (std::array<double, 3>{0.25, 0.25, 0.5}));
}

TEST(Consistency, aDriveWithoutTwistsCountsForThePoseAlone) {
  Consistency consistency;
  Judgement judgement = judgementWith(3.0, {0.1, 0.0, 0.0});
  consistency.add(judgement);
  judgement.twist_nees = 5.0;
  consistency.add(judgement);
  judgement.twists = 0;
  judgement.twist_nees = 0.0;
  consistency.add(judgement);
  EXPECT_EQ(consistency.drives(), 3u);
  EXPECT_DOUBLE_EQ(consistency.meanTwistNees(), 4.0);
  EXPECT_DOUBLE_EQ(consistency.twistNeesStandardError(), 1.0);  // of 3 and 5
}

void expectSame(const ConsistencyOverDistance& a, const ConsistencyOverDistance& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t place = 0; place < a.size(); ++place) {
    EXPECT_EQ(a[place].drives(), b[place].drives());
    EXPECT_EQ(a[place].meanNees(), b[place].meanNees());
    EXPECT_EQ(a[place].meanTwistNees(), b[place].meanTwistNees());
    EXPECT_EQ(a[place].errorCovariance(), b[place].errorCovariance());
    EXPECT_EQ(a[place].regionCoverage(), b[place].regionCoverage());
  }
}

/// More drives than blocks of them, and a last block that is not full.
TEST(StudyConsistency, theThreadsMakeNoDifference) {
  StudySettings study = studyOf({cycabOdometry(), cycabOdometry(AxleSelection::kRear)}, "fig4");
  study.drive.duration = 3.0;
  study.drives = 700;
  study.places = 3;
  study.threads = 1;
  const auto one = studyConsistency(study);
  study.threads = 5;
  const auto five = studyConsistency(study);
  ASSERT_EQ(one.size(), 2u);
  for (std::size_t k = 0; k < one.size(); ++k) expectSame(one[k], five[k]);
  EXPECT_EQ(one[0].back().drives(), 700u);
  EXPECT_NE(one[0].back().meanNees(), one[1].back().meanNees());
}

TEST(StudyConsistency, placesLieAtEqualDistances) {
  StudySettings study = studyOf({cycabOdometry()}, "circle");  // 60 m
  study.drives = 2;
  study.places = 4;
  const auto results = studyConsistency(study);
  // A sample lies every 4 cm.
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(results[0][k].distance(), 15.0 * static_cast<double>(k + 1), 0.05);
}

TEST(StudyConsistency, progressEndsWithEveryDrive) {
  StudySettings study = studyOf({cycabOdometry()}, "fig4");
  study.drive.duration = 0.5;
  study.drives = 300;
  std::size_t last = 0;
  study.progress = [&last](std::size_t drives) {
    EXPECT_GT(drives, last);
    last = drives;
  };
  studyConsistency(study);
  EXPECT_EQ(last, 300u);
}

/// A Gaussian believes in its own shares; particles count themselves, 1/200 of them at a time.
TEST(StudyConsistency, theMethodSaysWhatSharesItBelieves) {
  StudySettings study = studyOf({cycabOdometry(), cycabOdometry()}, "fig4");
  study.odometries[1].options.uncertainty = Uncertainty::kMonteCarlo;
  study.odometries[1].options.particles.count = 200;
  study.drive.duration = 3.0;
  study.drives = 2;
  const auto results = studyConsistency(study);
  EXPECT_EQ(results[0][0].expectedRegionCoverage(), sigmaShares());
  const std::array<double, 3> believed = results[1][0].expectedRegionCoverage();
  EXPECT_NE(believed, sigmaShares());
  // Early in a drive the cloud is nearly Gaussian: 4 standard deviations of a share of 200 particles.
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(believed[k], sigmaShares()[k],
                4.0 * std::sqrt(sigmaShares()[k] * (1.0 - sigmaShares()[k]) / 200.0));
}

TEST(StudyConsistency, nonsenseIsRefused) {
  StudySettings study = studyOf({cycabOdometry()}, "fig4");
  EXPECT_THROW(studyConsistency(study), std::invalid_argument) << "no drives";
  study.drives = 1;
  study.drive.scenario = "eights";
  EXPECT_THROW(studyConsistency(study), simulation::ScenarioError);
}

}  // namespace
}  // namespace bs_car_odometry::laboratory
