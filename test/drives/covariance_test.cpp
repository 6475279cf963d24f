// The first-order covariance against simulated noisy drives: noise only, the car's parameters as configured.
#include "cars.hpp"
#include "mean_error.hpp"

#include "bs_car_odometry/laboratory/chi_square.hpp"
#include "bs_car_odometry/laboratory/consistency.hpp"

#include "support/figure.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <string>

namespace bs_car_odometry::drives {
namespace {

using laboratory::Consistency;

constexpr std::size_t kDrives = 10000;
constexpr std::uint64_t kFirstSeed = 1000;
/// At 20 Hz the sampling of the steering alone moves the end of the slalom by 2.8 mm, four standard errors of
/// the mean; at 50 Hz by 0.4 mm.
constexpr double kRate = 50.0;
constexpr double kSubstep = 0.01;

DriveSettings noisyDrive(const char* scenario) {
  DriveSettings drive;
  drive.scenario = scenario;
  drive.rate = kRate;
  drive.substep = kSubstep;
  drive.seed = kFirstSeed;
  drive.noise = NoiseModel();
  return drive;
}

OdometryConfiguration noiseOnly(AxleSelection axles) {
  OdometryConfiguration configuration = odometryOf(cycab(AxleGeometry::kAckermann, 1e-5), axles);
  configuration.noise.systematic = {0.0, 0.0, 0.0, 0.0};
  return configuration;
}

/// What the noise-free drive lets one expect.
struct Prediction {
  Eigen::Matrix3d covariance;
  Eigen::Vector3d mean;  ///< of the error
};

Prediction predict(const OdometryConfiguration& configuration, DriveSettings settings) {
  settings.noise.reset();
  const std::vector<Sample> drive = record(configuration.vehicle, settings);
  return {endOf(configuration, drive).pose_covariance, meanError(configuration, drive)};
}

Eigen::Vector3d standardErrors(const Consistency& ends) {
  return ends.errorCovariance().diagonal().cwiseSqrt() / std::sqrt(static_cast<double>(kDrives));
}

void print(const Consistency& ends, const Prediction& prediction, AxleSelection axles) {
  const Eigen::IOFormat row(4, 0, " ", " ");
  const Eigen::Vector3d sigma = prediction.covariance.diagonal().cwiseSqrt();
  const Eigen::Vector3d mean = ends.meanError();
  std::cout << "  axles " << name(axles) << "\n    standard deviations, first order: " << sigma.format(row)
            << "; simulated over first order: "
            << ends.errorCovariance().diagonal().cwiseSqrt().cwiseQuotient(sigma).format(row)
            << "\n    mean error: " << mean.format(row)
            << ", in standard errors: " << mean.cwiseQuotient(standardErrors(ends)).format(row)
            << ", second order expects: " << prediction.mean.cwiseQuotient(standardErrors(ends)).format(row)
            << "\n    mean NEES: " << ends.meanNees() << std::endl;
}

/// Each standard deviation within 5 %, each correlation within 0.05.
void expectCovariance(const Consistency& ends, const Prediction& prediction) {
  const Eigen::Vector3d sigma = prediction.covariance.diagonal().cwiseSqrt();
  const Eigen::Matrix3d scale = sigma * sigma.transpose();
  const Eigen::Matrix3d simulated = ends.errorCovariance().cwiseQuotient(scale);
  const Eigen::Matrix3d predicted = prediction.covariance.cwiseQuotient(scale);
  for (Eigen::Index i = 0; i < 3; ++i)
    EXPECT_NEAR(std::sqrt(simulated(i, i)), 1.0, 0.05) << "component " << i;
  const Eigen::Vector3d inflation = simulated.diagonal().cwiseSqrt();
  const Eigen::Matrix3d correlations = simulated.cwiseQuotient(inflation * inflation.transpose());
  EXPECT_LT((correlations - predicted).cwiseAbs().maxCoeff(), 0.05) << correlations << "\n\n" << predicted;
}

/// Within 3 standard errors of where second order expects it; with both axles that is the truth itself.
void expectMean(const Consistency& ends, const Prediction& prediction, AxleSelection axles) {
  const Eigen::Vector3d limit = 3.0 * standardErrors(ends);
  const Eigen::Vector3d expected = axles == AxleSelection::kBoth ? Eigen::Vector3d::Zero() : prediction.mean;
  for (Eigen::Index i = 0; i < 3; ++i)
    EXPECT_LT(std::abs(ends.meanError()(i) - expected(i)), limit(i)) << "component " << i;
}

/// The mean of N chi-squares of 3 degrees of freedom lies in its 99.9 % interval.
void expectConsistent(const Consistency& ends) {
  const laboratory::Interval interval = laboratory::meanInterval(3.0, kDrives);
  EXPECT_GE(ends.meanNees(), interval.low);
  EXPECT_LE(ends.meanNees(), interval.high);
}

class FirstOrder : public testing::TestWithParam<const char*> {};

TEST_P(FirstOrder, O4_agreesWithTenThousandNoisyDrives) {
  laboratory::StudySettings settings;
  settings.drives = kDrives;
  settings.drive = noisyDrive(GetParam());
  for (const AxleSelection axles : {AxleSelection::kBoth, AxleSelection::kRear})
    settings.odometries.push_back(noiseOnly(axles));
  std::cout << GetParam() << ", " << kDrives << " drives, seeds from " << kFirstSeed << " on" << std::endl;

  const std::vector<laboratory::ConsistencyOverDistance> results = laboratory::studyConsistency(settings);
  double largest = 0.0;
  for (std::size_t k = 0; k < results.size(); ++k) {
    const AxleSelection axles = settings.odometries[k].options.axles;
    SCOPED_TRACE(std::string("axles ") + name(axles));
    const Prediction prediction = predict(settings.odometries[k], settings.drive);
    const Consistency& ends = results[k].back();
    print(ends, prediction, axles);
    expectCovariance(ends, prediction);
    expectMean(ends, prediction, axles);
    expectConsistent(ends);
    largest = std::max(largest, ends.meanNees());
  }
  recordFigure("first order, 10000 drives: largest mean NEES %.2f of 3 dimensions", largest);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, FirstOrder, testing::Values("circle", "fig4", "slalom_eight"),
                         [](const auto& scenario) { return std::string(scenario.param); });

}  // namespace
}  // namespace bs_car_odometry::drives
