#include "recorded_consistency.hpp"

#include "bs_car_odometry/laboratory/error.hpp"
#include "bs_car_odometry/laboratory/parallel.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace bs_car_odometry::tools {

namespace {

// Runs of the same path end as near to each other as this [of the distance; rad].
constexpr double kSameDistance = 0.05;
constexpr double kSamePosition = 0.1;
constexpr double kSameHeading = 0.3;

double mahalanobis(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  return error.dot(covariance.llt().solve(error));
}

/// What the runs left over say of the ends of the others.
class Judge {
 public:
  Judge(const LinearisedRuns& runs, const VarianceFit& all, const std::function<bool(std::size_t)>& uses)
      : runs_(runs), fit_(runs.fit(uses, all.variances)) {
    const VarianceComponents model = runs.model(uses);
    gains_ = model.gains(fit_.variances);
    systematic_ = model.systematicVariances(fit_.variances);
  }

  EndJudgement operator()(std::size_t run) const {
    const DriveErrors& errors = runs_.errors()[run];
    const GainEstimate& gains = gains_[runs_.wheelsOf(run)];
    const Eigen::MatrixXd& Phi = errors.end.sensitivity;
    const Eigen::Vector3d correction = Phi * gains.mean;
    Eigen::MatrixXd of_gains = gains.covariance;
    of_gains.diagonal() += systematic_;
    EndJudgement judgement;
    judgement.error = errors.end.error - correction;
    judgement.covariance = errors.end.covariance(fit_.variances) + Phi * of_gains * Phi.transpose();
    judgement.d2 = mahalanobis(judgement.error.head<2>(), judgement.covariance.topLeftCorner<2, 2>());
    const Pose2 estimate{errors.odometry.x + correction.x(), errors.odometry.y + correction.y(),
                         errors.odometry.yaw + correction.z()};
    judgement.nees = laboratory::exponentialNees(estimate, judgement.covariance, errors.truth);
    return judgement;
  }

 private:
  const LinearisedRuns& runs_;
  VarianceFit fit_;
  std::vector<GainEstimate> gains_;  ///< of each set of wheels
  Eigen::VectorXd systematic_;       ///< variances of the gains between recordings
};

/// Each run, and then each recording, on whatever processor is free.
std::vector<JudgedRun> judgeAll(const LinearisedRuns& runs, const VarianceFit& fit) {
  const std::size_t count = runs.runs().size();
  std::vector<JudgedRun> judged(count);
  const auto leaveRunOut = [&](std::size_t i) {
    const RecordedRun& run = runs.runs()[i];
    const Judge others(runs, fit, [i](std::size_t other) { return other != i; });
    judged[i] = {run.drive.name, run.wheels,    run.recording, runs.errors()[i].distance,
                 others(i),      EndJudgement()};
  };
  const auto leaveRecordingOut = [&](std::size_t recording) {
    const auto elsewhere = [&](std::size_t run) { return runs.recordingOf(run) != recording; };
    const Judge others(runs, fit, elsewhere);
    for (std::size_t i = 0; i < count; ++i)
      if (!elsewhere(i)) judged[i].without_recording = others(i);
  };
  Progress progress("leaving runs out", static_cast<double>(count + runs.recordings()));
  laboratory::runInParallel(count, 0, leaveRunOut,
                            [&](std::size_t done) { progress.update(static_cast<double>(done)); });
  laboratory::runInParallel(runs.recordings(), 0, leaveRecordingOut,
                            [&](std::size_t done) { progress.update(static_cast<double>(count + done)); });
  return judged;
}

bool samePath(const DriveErrors& a, const DriveErrors& b) {
  return std::abs(a.distance - b.distance) < kSameDistance * a.distance &&
         (a.odometry.position() - b.odometry.position()).norm() < kSamePosition * a.distance &&
         std::abs(a.odometry.yaw - b.odometry.yaw) < kSameHeading;
}

RepeatedPath scatter(const LinearisedRuns& runs, const VarianceFit& fit,
                     const std::vector<std::size_t>& members) {
  RepeatedPath path;
  const auto n = static_cast<double>(members.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  for (const std::size_t i : members) {
    path.runs.push_back(runs.runs()[i].drive.name);
    mean += runs.errors()[i].end.error / n;
    noise += runs.errors()[i].end.covariance(fit.variances) / n;
  }
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const std::size_t i : members) {
    const Eigen::Vector3d departure = runs.errors()[i].end.error - mean;
    squares += departure.cwiseAbs2();
    path.chi_square += mahalanobis(departure.head<2>(), noise.topLeftCorner<2, 2>());
  }
  path.measured_std = (squares / (n - 1.0)).cwiseSqrt();
  path.predicted_std = noise.diagonal().cwiseSqrt();
  path.degrees_of_freedom = 2.0 * (n - 1.0);
  return path;
}

std::vector<RepeatedPath> repeatedPaths(const LinearisedRuns& runs, const VarianceFit& fit) {
  std::vector<RepeatedPath> paths;
  std::vector<bool> taken(runs.runs().size(), false);
  for (std::size_t i = 0; i < taken.size(); ++i) {
    std::vector<std::size_t> members;
    for (std::size_t j = i; j < taken.size(); ++j)
      if (!taken[j] && runs.recordingOf(i) == runs.recordingOf(j) &&
          samePath(runs.errors()[i], runs.errors()[j]))
        members.push_back(j);
    if (taken[i] || members.size() < 2) continue;
    for (const std::size_t j : members) taken[j] = true;
    paths.push_back(scatter(runs, fit, members));
  }
  return paths;
}

}  // namespace

double shareBelow(double limit, const std::vector<JudgedRun>& runs, EndJudgement JudgedRun::*judgement) {
  const auto below = std::count_if(runs.begin(), runs.end(),
                                   [&](const JudgedRun& run) { return (run.*judgement).d2 < limit; });
  return runs.empty() ? 0.0 : static_cast<double>(below) / static_cast<double>(runs.size());
}

RecordedConsistency judgeRecordedRuns(const std::vector<RecordedRun>& runs, const Parameters& parameters,
                                      const NoiseFitSettings& settings) {
  const auto [linearised, fit] = linearisedFit(runs, parameters, settings);
  if (linearised.recordings() < 2)
    throw InputError("runs of at least two recordings are needed, so that one can be judged by the others");
  return {linearised.describe(fit), judgeAll(linearised, fit), repeatedPaths(linearised, fit)};
}

std::vector<RecordedRun> runsLongerThan(double distance, std::vector<RecordedRun> runs,
                                        const Parameters& parameters) {
  const auto is_short = [&](const RecordedRun& run) {
    return !(driveErrors(run.drive, parameters, NoiseUnknowns(), ErrorSettings()).distance > distance);
  };
  runs.erase(std::remove_if(runs.begin(), runs.end(), is_short), runs.end());
  return runs;
}

}  // namespace bs_car_odometry::tools
