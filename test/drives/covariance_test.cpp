// The first-order covariance against simulated noisy drives: noise only, the car's parameters as configured.
#include "cars.hpp"
#include "mean_error.hpp"
#include "monte_carlo.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <string>

namespace bs_car_odometry::drives {
namespace {

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

Eigen::Vector3d standardErrors(const EndErrors& ends) {
  return ends.covariance().diagonal().cwiseSqrt() / std::sqrt(static_cast<double>(kDrives));
}

void print(const EndErrors& ends, const Prediction& prediction, AxleSelection axles) {
  const Eigen::IOFormat row(4, 0, " ", " ");
  const Eigen::Vector3d sigma = prediction.covariance.diagonal().cwiseSqrt();
  const Eigen::Vector3d mean = ends.mean();
  std::cout << "  axles " << name(axles) << "\n    standard deviations, first order: " << sigma.format(row)
            << "; simulated over first order: "
            << ends.covariance().diagonal().cwiseSqrt().cwiseQuotient(sigma).format(row)
            << "\n    mean error: " << mean.format(row)
            << ", in standard errors: " << mean.cwiseQuotient(standardErrors(ends)).format(row)
            << ", second order expects: " << prediction.mean.cwiseQuotient(standardErrors(ends)).format(row)
            << "\n    mean NEES: " << ends.meanNees() << std::endl;
}

/// Each standard deviation within 5 %, each correlation within 0.05.
void expectCovariance(const EndErrors& ends, const Prediction& prediction) {
  const Eigen::Vector3d sigma = prediction.covariance.diagonal().cwiseSqrt();
  const Eigen::Matrix3d scale = sigma * sigma.transpose();
  const Eigen::Matrix3d simulated = ends.covariance().cwiseQuotient(scale);
  const Eigen::Matrix3d predicted = prediction.covariance.cwiseQuotient(scale);
  for (Eigen::Index i = 0; i < 3; ++i)
    EXPECT_NEAR(std::sqrt(simulated(i, i)), 1.0, 0.05) << "component " << i;
  const Eigen::Vector3d inflation = simulated.diagonal().cwiseSqrt();
  const Eigen::Matrix3d correlations = simulated.cwiseQuotient(inflation * inflation.transpose());
  EXPECT_LT((correlations - predicted).cwiseAbs().maxCoeff(), 0.05) << correlations << "\n\n" << predicted;
}

/// Within 3 standard errors of where second order expects it; with both axles that is the truth itself.
void expectMean(const EndErrors& ends, const Prediction& prediction, AxleSelection axles) {
  const Eigen::Vector3d limit = 3.0 * standardErrors(ends);
  const Eigen::Vector3d expected = axles == AxleSelection::kBoth ? Eigen::Vector3d::Zero() : prediction.mean;
  for (Eigen::Index i = 0; i < 3; ++i)
    EXPECT_LT(std::abs(ends.mean()(i) - expected(i)), limit(i)) << "component " << i;
}

/// The mean of N chi-squares of 3 degrees of freedom: 3 +/- 3.29 sqrt(6/N) at 99.9 %.
void expectConsistent(const EndErrors& ends) {
  EXPECT_NEAR(ends.meanNees(), 3.0, 3.29 * std::sqrt(6.0 / static_cast<double>(kDrives)));
}

class FirstOrder : public testing::TestWithParam<const char*> {};

TEST_P(FirstOrder, agreesWithTenThousandNoisyDrives) {
  MonteCarloSettings settings;
  settings.drives = kDrives;
  settings.drive = noisyDrive(GetParam());
  for (const AxleSelection axles : {AxleSelection::kBoth, AxleSelection::kRear})
    settings.odometries.push_back(noiseOnly(axles));
  std::cout << GetParam() << ", " << kDrives << " drives, seeds from " << kFirstSeed << " on" << std::endl;

  const std::vector<EndErrors> results = simulateDrives(settings);
  for (std::size_t k = 0; k < results.size(); ++k) {
    const AxleSelection axles = settings.odometries[k].options.axles;
    SCOPED_TRACE(std::string("axles ") + name(axles));
    const Prediction prediction = predict(settings.odometries[k], settings.drive);
    print(results[k], prediction, axles);
    expectCovariance(results[k], prediction);
    expectMean(results[k], prediction, axles);
    expectConsistent(results[k]);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, FirstOrder, testing::Values("circle", "fig4", "slalom_eight"),
                         [](const auto& scenario) { return std::string(scenario.param); });

}  // namespace
}  // namespace bs_car_odometry::drives
