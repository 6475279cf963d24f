#include "bs_car_odometry/calibration/refinement.hpp"

#include "bs_car_odometry/laboratory/chi_square.hpp"
#include "calibration/refinement/fit.hpp"
#include "calibration/refinement/residuals.hpp"
#include "simulated_calibration.hpp"

#include <ceres/autodiff_cost_function.h>
#include <ceres/covariance.h>
#include <ceres/problem.h>
#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <iostream>

namespace bs_car_odometry::calibration {
namespace {

double errorOf(const Refinement& refined, const ParameterVector& truth, std::size_t parameter) {
  const auto i = static_cast<Eigen::Index>(parameter);
  return refined.values[i] - truth[i];
}

/// What many drives show of the refinement.
struct Study {
  ParameterVector square{ParameterVector::Zero()};  ///< mean square errors
  double nees{0.0};
  double largest{0.0};  ///< error over bound
  int converged{0};
  int disagreements{0};

  double ratio(std::size_t parameter, const ParameterVector& bound) const {
    const auto i = static_cast<Eigen::Index>(parameter);
    return std::sqrt(square[i]) / bound[i];
  }
};

Study study(const std::string& scenario, int runs, const LaserOutliers& outliers = {}) {
  const Parameters parameters = withPrior(0.02);
  const ParameterVector bound = boundOf(scenario, parameters);
  std::cout << scenario << ", seeds 1 to " << runs << "\n";
  Study study;
  for (int seed = 1; seed <= runs; ++seed) {
    SimulatedDrive simulated = drawnDrive(scenario, parameters, static_cast<std::uint64_t>(seed));
    simulated.outliers = outliers;
    const CalibratedDrive calibrated = calibrate(simulated, parameters);
    const Refinement refined = refine({&calibrated.drive}, parameters);
    Eigen::Vector3d error;
    Eigen::Matrix3d P;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const auto p = static_cast<Eigen::Index>(kRearGains[i]);
      error[k] = refined.values[p] - simulated.truth[p];
      study.square[p] += error[k] * error[k] / runs;
      study.largest = std::max(study.largest, std::abs(error[k]) / bound[p]);
      for (std::size_t j = 0; j < 3; ++j)
        P(k, static_cast<Eigen::Index>(j)) = refined.covariance(p, static_cast<Eigen::Index>(kRearGains[j]));
    }
    study.nees += error.dot(P.llt().solve(error)) / runs;
    study.converged += refined.converged ? 1 : 0;
    study.disagreements += static_cast<int>(disagreements(calibrated.filter, refined).size());
  }
  for (const std::size_t p : kRearGains)
    std::cout << "  " << parameterName(p) << " RMSE / bound " << study.ratio(p, bound) << "\n";
  std::cout << "  mean NEES " << study.nees << "\n";
  for (const std::size_t p : kRearGains) {
    // The target; its own sampling deviation is 5 % for 200 runs and 7 % for 100.
    EXPECT_LE(study.ratio(p, bound), 1.15) << parameterName(p);
  }
  EXPECT_EQ(study.converged, runs);
  EXPECT_LE(study.largest, 10.0) << "a lost run";
  return study;
}

TEST(Refinement, FindsTheGainsOfADriveWithoutNoise) {
  const Parameters parameters = exactParameters();
  const SimulatedDrive simulated = exactDrive(parameters);
  const CalibratedDrive calibrated = calibrate(simulated, parameters);
  const Refinement refined = refine({&calibrated.drive}, parameters);
  EXPECT_TRUE(refined.converged);
  // Readings of single precision: 6e-8 of each step, and 3e-8 rad of angle.
  for (const std::size_t p : kRearGains) EXPECT_NEAR(errorOf(refined, simulated.truth, p), 0.0, 1e-6);
}

TEST(Refinement, ReachesTheBoundOnFig4) {
  const Study result = study("fig4", 200);
  EXPECT_TRUE(laboratory::meanInterval(3.0, 200).holds(result.nees)) << result.nees;
  EXPECT_EQ(result.disagreements, 0);
}

TEST(Refinement, ReachesTheBoundOnSlalomEight) {
  const Study result = study("slalom_eight", 100);
  EXPECT_TRUE(laboratory::meanInterval(3.0, 100).holds(result.nees)) << result.nees;
  EXPECT_EQ(result.disagreements, 0);
}

// The soft weight costs a tenth of the poses' information at most, and the bound is that without outliers.
TEST(Refinement, BearsOutliers) {
  study("fig4", 100, {0.1, 1.0, 0.3});
  study("fig4", 100, {0.3, 1.0, 0.3});
  study("fig4", 100, {0.3, 0.2, 0.05});
}

TEST(Refinement, AgreesWithTheFilterOnBothAxles) {
  const Parameters parameters = withPrior(0.05, AxleSelection::kBoth);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const CalibratedDrive calibrated = calibrate(drawnDrive("fig4", parameters, seed), parameters);
    const Refinement refined = refine({&calibrated.drive}, parameters);
    EXPECT_TRUE(refined.converged);
    EXPECT_TRUE(disagreements(calibrated.filter, refined).empty());
    for (std::size_t p = 0; p < kCount; ++p) {
      if (!refined.estimated[p]) continue;
      const auto i = static_cast<Eigen::Index>(p);
      const double sigma = deviation(refined.covariance, p);
      // They differ in where they linearise and in the first pose, which the filter begins at.
      EXPECT_NEAR(refined.values[i], calibrated.filter.values[i], 0.3 * sigma) << parameterName(p);
      EXPECT_NEAR(deviation(calibrated.filter.covariance, p), sigma, 0.03 * sigma) << parameterName(p);
    }
  }
}

TEST(Refinement, SaysWhereFilterAndRefinementDisagree) {
  FilterEstimate filter;
  Refinement refined;
  refined.estimated[systematic::kRearLeft] = true;
  filter.covariance(systematic::kRearLeft, systematic::kRearLeft) = 4e-6;
  refined.covariance(systematic::kRearLeft, systematic::kRearLeft) = 1e-6;
  refined.values[systematic::kRearLeft] = -0.0019;
  EXPECT_TRUE(disagreements(filter, refined).empty());
  refined.values[systematic::kRearLeft] = -0.0021;
  const std::vector<Disagreement> found = disagreements(filter, refined);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].parameter, std::size_t{systematic::kRearLeft});
  EXPECT_DOUBLE_EQ(found[0].difference, -0.0021);
  EXPECT_DOUBLE_EQ(found[0].deviation, 0.002);
}

TEST(Refinement, FindsGainsThatAreTenPercentOffWithoutTheFilter) {
  const Parameters parameters = withPrior(0.05);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SimulatedDrive simulated = drawnDrive("slalom_eight", parameters, seed);
    simulated.truth.segment<3>(systematic::kRearRight) << 1.1, 1.1, 0.9;
    const CalibratedDrive calibrated = calibrate(simulated, parameters);
    const Refinement refined = refine({&calibrated.drive}, parameters);
    EXPECT_TRUE(refined.converged);
    for (const std::size_t p : kRearGains)  // 4 standard deviations: one draw in 16,000
      EXPECT_NEAR(errorOf(refined, simulated.truth, p), 0.0, 4.0 * deviation(refined.covariance, p));
  }
}

TEST(Refinement, StopsAtTheBoundsOfTheGainsAndSaysSo) {
  const Parameters parameters = withPrior(1.0);
  SimulatedDrive simulated = drawnDrive("fig4", parameters, 1);
  simulated.truth.segment<3>(systematic::kRearRight) << 3.0, 3.0, 1.0;
  const CalibratedDrive calibrated = calibrate(simulated, parameters);
  const Refinement refined = refine({&calibrated.drive}, parameters);
  EXPECT_FALSE(refined.converged);
  // Where there is no solution within, one gain at its bound is enough to say so.
  EXPECT_TRUE(refined.at_bound[systematic::kRearRight] || refined.at_bound[systematic::kRearLeft]);
  for (const std::size_t p : kRearGains) {
    EXPECT_LE(refined.values[static_cast<Eigen::Index>(p)], kLargestGain);
    EXPECT_GE(refined.values[static_cast<Eigen::Index>(p)], kLeastGain);
  }
}

TEST(Refinement, StraightDriveLeavesTheTrackAtItsPrior) {
  const Parameters parameters = withPrior(0.02);
  const SimulatedDrive simulated = drawnDrive("straight", parameters, 1);
  const CalibratedDrive calibrated = calibrate(simulated, parameters);
  const Refinement refined = refine({&calibrated.drive}, parameters);
  EXPECT_TRUE(refined.converged);
  EXPECT_NEAR(deviation(refined.covariance, systematic::kRearTrack), 0.02, 0.0002);
  // The noise of the heading is in the sensitivity to k_b too: the filter takes that out (C14), the fit does
  // not, and wanders by less than its own deviation.
  EXPECT_NEAR(refined.values[systematic::kRearTrack], 1.0, 0.02);
  EXPECT_NEAR(calibrated.filter.values[systematic::kRearTrack], 1.0, 0.004);
  EXPECT_LT(deviation(refined.covariance, systematic::kRearRight), 0.01);  // observed
}

TEST(Refinement, FindsLaserMountAndDelayToo) {
  Parameters parameters = withPrior(0.02);
  parameters.calibration.estimate = {"gains", "laser_mount", "time_offset"};
  double nees = 0.0;
  constexpr int kRuns = 30;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const SimulatedDrive simulated = drawnDrive("slalom_eight", parameters, seed);
    const CalibratedDrive calibrated = calibrate(simulated, parameters);
    const Refinement refined = refine({&calibrated.drive}, parameters);
    EXPECT_TRUE(refined.converged);
    Eigen::VectorXd error(7);
    Eigen::MatrixXd P(7, 7);
    const std::array<std::size_t, 7> all{kRearGains[0], kRearGains[1], kRearGains[2], kLaserX,
                                         kLaserY,       kLaserYaw,     kTimeOffset};
    for (std::size_t i = 0; i < 7; ++i) {
      error[static_cast<Eigen::Index>(i)] = errorOf(refined, simulated.truth, all[i]);
      for (std::size_t j = 0; j < 7; ++j)
        P(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            refined.covariance(static_cast<Eigen::Index>(all[i]), static_cast<Eigen::Index>(all[j]));
    }
    nees += error.dot(P.llt().solve(error)) / kRuns;
    EXPECT_LT(deviation(refined.covariance, kTimeOffset), 0.01);  // 1 m/s against 0.02 m, 600 times
  }
  EXPECT_TRUE(laboratory::meanInterval(7.0, kRuns).holds(nees)) << nees;
}

TEST(Refinement, JoinsNothingAcrossAJumpOfTheLocaliser) {
  const Parameters parameters = withPrior(0.02);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SimulatedDrive simulated = drawnDrive("slalom_eight", parameters, seed);
    simulated.jump_after = 31.0;
    const CalibratedDrive calibrated = calibrate(simulated, parameters);
    const Refinement refined = refine({&calibrated.drive}, parameters);
    EXPECT_TRUE(refined.converged);
    for (const std::size_t p : kRearGains)
      EXPECT_NEAR(errorOf(refined, simulated.truth, p), 0.0, 4.0 * deviation(refined.covariance, p));
  }
}

/// Without the weight of the motion the mean NEES is 30 (measured).
TEST(Refinement, BelievesNoMotionOfAWheelThatSpins) {
  const Parameters parameters = withPrior(0.02);
  const ParameterVector bound = boundOf("slalom_eight", parameters);
  double square = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SimulatedDrive simulated = drawnDrive("wheel_spin", parameters, seed);
    const CalibratedDrive calibrated = calibrate(simulated, parameters);
    const Refinement refined = refine({&calibrated.drive}, parameters);
    for (const std::size_t p : kRearGains)
      square +=
          std::pow(errorOf(refined, simulated.truth, p) / bound[static_cast<Eigen::Index>(p)], 2) / 30.0;
  }
  EXPECT_LT(std::sqrt(square), 2.0);
}

TEST(Refinement, OfSeveralDrivesIsAsGoodAsTheirLength) {
  const Parameters parameters = withPrior(0.05);
  SimulatedDrive simulated = drawnDrive("fig4", parameters, 1);
  std::vector<CalibratedDrive> calibrated;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    simulated.seed = seed;
    calibrated.push_back(calibrate(simulated, parameters));
  }
  const Refinement one = refine({&calibrated[0].drive}, parameters);
  const Refinement four = refine(
      {&calibrated[0].drive, &calibrated[1].drive, &calibrated[2].drive, &calibrated[3].drive}, parameters);
  EXPECT_TRUE(four.converged);
  ASSERT_EQ(four.residuals.size(), 4U);
  for (const std::size_t p : kRearGains) {
    // Information adds up: half the deviation, but for the prior and the noise in the travel.
    EXPECT_NEAR(deviation(four.covariance, p) / deviation(one.covariance, p), 0.5, 0.03);
    EXPECT_NEAR(errorOf(four, simulated.truth, p), 0.0, 4.0 * deviation(four.covariance, p));
  }
}

TEST(Refinement, OfNothingDoesNotConverge) {
  const Parameters parameters = withPrior(0.05);
  EXPECT_FALSE(refine({}, parameters).converged);
  const CalibrationDrive empty;
  const Refinement refined = refine({&empty}, parameters);
  EXPECT_FALSE(refined.converged);
  EXPECT_EQ(refined.values, valuesOf(parameters));
}

TEST(Refinement, UsesEverySecondPoseOfALongDrive) {
  const Parameters parameters = withPrior(0.02);
  const SimulatedDrive simulated = drawnDrive("slalom_eight", parameters, 1);
  const CalibratedDrive calibrated = calibrate(simulated, parameters);
  RefinementOptions options;
  options.most_poses = 400;
  const Refinement all = refine({&calibrated.drive}, parameters);
  const Refinement half = refine({&calibrated.drive}, parameters, options);
  EXPECT_EQ(half.residuals[0].size(), (all.residuals[0].size() + 1) / 2);
  for (const std::size_t p : kRearGains) {
    // Mostly the wheels' noise limits the gains, not the laser.
    EXPECT_LT(deviation(half.covariance, p), 1.2 * deviation(all.covariance, p));
    EXPECT_GT(deviation(half.covariance, p), deviation(all.covariance, p));
    EXPECT_NEAR(errorOf(half, simulated.truth, p), 0.0, 4.0 * deviation(half.covariance, p));
  }
}

/// The same drive as a problem of its own, with outliers, so that weights count.
TEST(ChainFilter, CovarianceIsThatOfCeres) {
  Parameters parameters = withPrior(0.02);
  parameters.calibration.estimate = {"gains", "laser_mount", "time_offset"};
  SimulatedDrive simulated = drawnDrive("fig4", parameters, 3);
  simulated.outliers = {0.1, 1.0, 0.3};
  const CalibratedDrive calibrated = calibrate(simulated, parameters);
  Refinement refined = refine({&calibrated.drive}, parameters);
  std::vector<Pose2> poses(calibrated.drive.lasers().size());
  for (const LaserResidual& residual : refined.residuals[0]) poses[residual.laser] = residual.pose;
  Chain chain = makeChain(calibrated.drive, parameters, refined.values, poses, {});
  ASSERT_EQ(chain.nodes.size(), refined.residuals[0].size());

  SoftWeightLoss soft;
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  const ParameterPrior prior(parameters);
  double* motion = refined.values.data();
  double* laser = motion + kMotionBlock;
  using MotionPrior = PriorResidual<0, kMotionBlock>;
  using LaserPrior = PriorResidual<kMotionBlock, kLaserBlock>;
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<MotionPrior, kMotionBlock, kMotionBlock>(new MotionPrior(prior)),
      nullptr, motion);
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<LaserPrior, kLaserBlock, kLaserBlock>(new LaserPrior(prior)), nullptr,
      laser);
  for (std::size_t i = 0; i < chain.nodes.size(); ++i) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<LaserPoseResidual, 3, 3, kLaserBlock>(
                                 new LaserPoseResidual(chain.nodes[i], refined.values, prior.estimated)),
                             &soft, chain.nodes[i].pose.data(), laser);
    if (chain.nodes[i].linked)
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<MotionResidual, 3, 3, 3, kMotionBlock>(
                                   new MotionResidual(chain.nodes[i].link, refined.values, prior.estimated)),
                               nullptr, chain.nodes[i - 1].pose.data(), chain.nodes[i].pose.data(), motion);
  }
  ceres::Covariance covariance{ceres::Covariance::Options()};
  ASSERT_TRUE(covariance.Compute({{motion, motion}, {motion, laser}, {laser, laser}}, &problem));
  Eigen::Matrix<double, kMotionBlock, kMotionBlock, Eigen::RowMajor> P_motion;
  Eigen::Matrix<double, kMotionBlock, kLaserBlock, Eigen::RowMajor> P_cross;
  Eigen::Matrix<double, kLaserBlock, kLaserBlock, Eigen::RowMajor> P_laser;
  covariance.GetCovarianceBlock(motion, motion, P_motion.data());
  covariance.GetCovarianceBlock(motion, laser, P_cross.data());
  covariance.GetCovarianceBlock(laser, laser, P_laser.data());
  ParameterMatrix P;
  P << P_motion, P_cross, P_cross.transpose(), P_laser;
  for (const Eigen::Index i : prior.active)
    for (const Eigen::Index j : prior.active)  // the last step of the solver moves the poses by so little
      EXPECT_NEAR(refined.covariance(i, j), P(i, j), 1e-4 * std::sqrt(P(i, i) * P(j, j)));
}

/// A fit is where no parameter wants to move: the elimination finds the solver's solution.
TEST(ChainFilter, FindsNothingLeftAfterAFit) {
  const Parameters parameters = withPrior(0.02);
  const CalibratedDrive calibrated = calibrate(drawnDrive("fig4", parameters, 5), parameters);
  const Drives drives{&calibrated.drive};
  Fit fit(drives, parameters, {});
  fit.run();
  const std::vector<Chain> chains = fit.chainsWithWheelNoise();
  ChainFilter filter(fit.prior(), fit.values());
  Chain chain = chains[0];
  const std::vector<LaserResidual> residuals = fit.result().residuals[0];
  for (std::size_t i = 0; i < chain.nodes.size(); ++i) chain.nodes[i].weight = residuals[i].weight;
  filter.add(chain);
  const ParameterVector left = filter.correction();
  for (const std::size_t p : kRearGains)  // the rounds end at a hundredth
    EXPECT_LT(std::abs(left[static_cast<Eigen::Index>(p)]), 0.01 * deviation(filter.covariance(), p));
}

}  // namespace
}  // namespace bs_car_odometry::calibration
