#include "bs_car_odometry/laboratory/calibration_study.hpp"

#include "bs_car_odometry/calibration/calibrator.hpp"
#include "bs_car_odometry/calibration/drive_bound.hpp"
#include "bs_car_odometry/core/odometry_estimator.hpp"
#include "bs_car_odometry/laboratory/error.hpp"
#include "bs_car_odometry/laboratory/parallel.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace bs_car_odometry::laboratory {

namespace {

using calibration::FilterEstimate;
using calibration::ParameterVector;
using Eigen::Index;

constexpr double kRate = 50.0;             // [Hz]
constexpr std::size_t kPosesASecond = 10;  // of the laser
/// The loop after a calibration is another drive of the same car: seeds apart from those of all others.
constexpr std::uint64_t kLoopSeed = 1000000007;

std::vector<std::size_t> indicesOf(const calibration::ParameterMask& mask) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (mask[i]) indices.push_back(i);
  return indices;
}

/// The calibration's configuration in a case.
Parameters configurationOf(const CalibrationCase& what, const Parameters& configured) {
  Parameters parameters = configured;
  parameters.odometry.axles = what.axles;
  parameters.odometry.uncertainty = Uncertainty::kFirstOrder;
  parameters.calibration.estimate = what.estimate;
  CalibrationPrior& prior = parameters.calibration.prior;
  prior.k_r = prior.k_l = prior.k_b = what.prior;
  return parameters;
}

/// As the calibration has it; drives and bounds have the noise that is configured.
Parameters believedOf(const CalibrationCase& what, Parameters parameters) {
  NoiseModel& noise = parameters.noise;
  for (Distribution* error : {&noise.wheel, &noise.steering.angle, &noise.lateral, &noise.rear_law})
    if (what.believed_noise != 1.0) *error = what.believed_noise * error->std();
  return parameters;
}

/// What two cases must have in common to share a drive.
std::string driveKey(const std::string& scenario, const CalibrationCase& what) {
  std::ostringstream key;
  key << scenario << ' ' << static_cast<int>(what.gains.kind) << ' ' << what.gains.size << ' ' << what.noise;
  return key.str();
}

KnownDrive recordDrive(const std::string& scenario, const CalibrationCase& what, const Parameters& configured,
                       std::uint64_t gain_seed, std::uint64_t seed) {
  KnownDrive drive;
  drive.truth = configured;
  drive.truth.vehicle = trueVehicle(configured.vehicle, what.gains, gain_seed);
  DriveSettings settings;
  settings.scenario = scenario;
  settings.rate = kRate;
  settings.substep = 0.01;
  settings.seed = seed;
  if (what.noise) settings.noise = configured.noise;
  drive.samples = record(drive.truth.vehicle, settings);
  return drive;
}

double normalised(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd e = error.cwiseQuotient(sigma);
  return e.dot(covariance.cwiseQuotient(sigma * sigma.transpose()).ldlt().solve(e));
}

/// Pose and estimated parameters with their covariance.
struct Together {
  Eigen::VectorXd error;
  Eigen::MatrixXd covariance;
};

Together together(const FilterEstimate& estimate, const simulation::Pose& truth, const ParameterVector& error,
                  const std::vector<std::size_t>& estimated) {
  const auto n = static_cast<Index>(estimated.size());
  Together state{Eigen::VectorXd(3 + n), Eigen::MatrixXd(3 + n, 3 + n)};
  state.error.head<3>() << estimate.pose.x - truth.x, estimate.pose.y - truth.y,
      wrapAngle(estimate.pose.yaw - truth.yaw);
  state.covariance.topLeftCorner<3, 3>() = estimate.pose_covariance;
  for (Index i = 0; i < n; ++i) {
    const auto from = static_cast<Index>(estimated[static_cast<std::size_t>(i)]);
    state.error(3 + i) = error(from);
    state.covariance.block<3, 1>(0, 3 + i) = estimate.cross.col(from);
    state.covariance.block<1, 3>(3 + i, 0) = estimate.cross.col(from).transpose();
    for (Index j = 0; j < n; ++j)
      state.covariance(3 + i, 3 + j) =
          estimate.covariance(from, static_cast<Index>(estimated[static_cast<std::size_t>(j)]));
  }
  return state;
}

/// What is common to all drives of a case.
struct Prepared {
  CalibrationCase what;
  Parameters configured;
  std::vector<std::size_t> estimated;
  std::vector<ParameterVector> bounds;  ///< after each laser pose
  std::size_t settled{0};               ///< laser pose from which on the drive is judged
};

double distanceTo(const std::vector<Sample>& samples, std::size_t end) {
  double distance = 0.0;
  for (std::size_t i = 1; i <= end; ++i)
    distance +=
        std::hypot(samples[i].truth.x - samples[i - 1].truth.x, samples[i].truth.y - samples[i - 1].truth.y);
  return distance;
}

/// Linearised at the middle of the true gains; those drawn change the bound of each by about their own size.
Prepared prepare(const CalibrationCase& what, const Parameters& configured) {
  Prepared prepared{what, configurationOf(what, configured), {}, {}, 0};
  const calibration::ParameterMask mask = calibration::parametersToEstimate(prepared.configured);
  prepared.estimated = indicesOf(mask);
  CalibrationCase exact = what;
  exact.noise = false;
  if (what.gains.kind != TrueGains::Kind::kScenario) exact.gains.kind = TrueGains::Kind::kConfigured;
  const KnownDrive drive = recordDrive(what.scenario, exact, prepared.configured, 0, 0);
  const std::vector<OdometryUpdate> updates = odometryOf(drive.truth, drive.samples);
  calibration::DriveBound bound(drive.truth, mask, calibration::priorDeviations(prepared.configured));
  const LaserSigma& sigma = configured.laser_sigma;
  const Eigen::Vector3d deviations(sigma.position, sigma.position, sigma.yaw);
  const Eigen::Matrix3d R = deviations.cwiseAbs2().asDiagonal();
  for (std::size_t i = 0; i < updates.size(); ++i) {
    if (updates[i].step) bound.move(*updates[i].step);
    if (i % kLaserEvery != 0) continue;
    bound.update(R);
    prepared.bounds.push_back(bound.deviations());
    if (distanceTo(drive.samples, i) < what.settled) prepared.settled = prepared.bounds.size();
  }
  return prepared;
}

/// Runs one calibration and keeps what it says on the way.
class Follower {
 public:
  Follower(const Prepared& prepared, const KnownDrive& drive, double delay)
      : prepared_(prepared), drive_(drive), truth_(calibration::valuesOf(drive.truth)) {
    truth_(calibration::kTimeOffset) += delay;
  }

  CalibrationOutcome follow(const std::vector<OdometryUpdate>& updates,
                            const std::vector<calibration::LaserPose>& lasers) {
    calibration::Calibrator calibrator(believedOf(prepared_.what, prepared_.configured));
    calibrator.setListener([this](const calibration::CalibrationUpdate& update) { see(update); });
    first_ = lasers.front().stamp;
    auto laser = lasers.begin();
    for (const OdometryUpdate& update : updates) {
      for (; laser != lasers.end() && laser->stamp <= update.stamp; ++laser) calibrator.add(*laser);
      calibrator.add(update);
    }
    for (; laser != lasers.end(); ++laser) calibrator.add(*laser);
    conclude(calibrator);
    return outcome_;
  }

 private:
  std::size_t laserNumber(Time stamp) const {
    const double spacing = static_cast<double>(kLaserEvery) / kRate;
    return static_cast<std::size_t>(std::lround(toSeconds(stamp - first_) / spacing));
  }

  void see(const calibration::CalibrationUpdate& update) {
    ++outcome_.updates;
    nis_ += update.innovation.nis;
    second_ += update.innovation.nis;
    if (outcome_.updates % kPosesASecond == 0) {
      outcome_.worst_second_nis = std::max(outcome_.worst_second_nis, second_ / kPosesASecond);
      second_ = 0.0;
    }
    outcome_.estimate = update.estimate;
    last_ = laserNumber(update.stamp);
    if (last_ < prepared_.settled) return;
    const ParameterVector& bound = prepared_.bounds[last_];
    for (const std::size_t parameter : prepared_.estimated) {
      const auto i = static_cast<Index>(parameter);
      const double ratio = std::abs(update.estimate.values(i) - truth_(i)) / bound(i);
      outcome_.worst(i) = std::max(outcome_.worst(i), ratio);
    }
    if (last_ == prepared_.settled)
      outcome_.settled_deviation = update.estimate.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  }

  void conclude(const calibration::Calibrator& calibrator) {
    for (const std::size_t parameter : prepared_.estimated) {
      const auto i = static_cast<Index>(parameter);
      outcome_.error(i) = outcome_.estimate.values(i) - truth_(i);
    }
    const simulation::Pose& truth = drive_.samples[last_ * kLaserEvery].truth;
    const Together state = together(outcome_.estimate, truth, outcome_.error, prepared_.estimated);
    const Index n = state.error.size() - 3;
    outcome_.gain_nees = normalised(state.error.tail(n), state.covariance.bottomRightCorner(n, n));
    outcome_.state_nees = normalised(state.error, state.covariance);
    outcome_.mean_nis = nis_ / static_cast<double>(outcome_.updates);
    outcome_.observed = calibrator.observed();
    outcome_.relocalisations = calibrator.counts().relocalisations;
  }

  const Prepared& prepared_;
  const KnownDrive& drive_;
  ParameterVector truth_;
  CalibrationOutcome outcome_;
  Time first_;
  std::size_t last_{0};
  double nis_{0.0};
  double second_{0.0};  ///< sum of NIS in the present second
};

/// Dead reckoning by what a calibration has found, judged at a quarter, a half and the end of the way.
std::vector<LoopOutcome> driveLoop(const Parameters& configured, const FilterEstimate& found,
                                   const KnownDrive& loop) {
  Parameters parameters = configured;
  calibration::setValues(found.values, parameters);
  calibration::MotionModel model(configured);
  model.setValues(found.values);
  OdometryEstimator estimator(
      {parameters.vehicle, parameters.noise, parameters.odometry, parameters.limits, {}, {}});
  estimator.setSystematicCovariance(found.covariance.topLeftCorner<systematic::kCount, systematic::kCount>());
  const std::vector<OdometryUpdate> updates = odometryOf(configured, loop.samples);
  const double whole = distanceTo(loop.samples, loop.samples.size() - 1);
  std::vector<LoopOutcome> outcomes;
  double distance = 0.0;
  for (std::size_t i = 1; i < updates.size(); ++i) {
    const MeasuredStep& step = updates[i].step.value();
    estimator.step(model.adapted(step.readings), step.span.end - step.span.begin);
    const simulation::Pose& truth = loop.samples[i].truth;
    distance += std::hypot(truth.x - loop.samples[i - 1].truth.x, truth.y - loop.samples[i - 1].truth.y);
    const double part = outcomes.size() < 2 ? 0.25 * static_cast<double>(outcomes.size() + 1) : 1.0;
    if (i + 1 < updates.size() && distance < part * whole) continue;
    if (part == 1.0 && i + 1 < updates.size()) continue;
    const Eigen::Vector3d error = poseError(estimator.estimate(), truth);
    outcomes.push_back({exponentialNees(estimator.estimate(), truth), distance, error.head<2>().norm()});
  }
  return outcomes;
}

/// The drives of one seed, recorded once for all cases.
class Drives {
 public:
  Drives(std::uint64_t seed, const Parameters& configured) : seed_(seed), configured_(configured) {}

  const KnownDrive& drive(const CalibrationCase& what) { return drive(what.scenario, what, seed_); }
  const KnownDrive& loop(const CalibrationCase& what) { return drive(what.loop, what, seed_ + kLoopSeed); }

  const std::vector<OdometryUpdate>& odometry(const Prepared& prepared) {
    const std::string key = driveKey(prepared.what.scenario, prepared.what) + ' ' +
                            std::to_string(static_cast<int>(prepared.what.axles));
    const auto found = odometry_.find(key);
    if (found != odometry_.end()) return found->second;
    return odometry_.emplace(key, odometryOf(prepared.configured, drive(prepared.what).samples))
        .first->second;
  }

 private:
  const KnownDrive& drive(const std::string& scenario, const CalibrationCase& what, std::uint64_t seed) {
    const std::string key = driveKey(scenario, what) + ' ' + std::to_string(seed);
    const auto found = drives_.find(key);
    if (found != drives_.end()) return found->second;
    return drives_.emplace(key, recordDrive(scenario, what, configured_, seed_, seed)).first->second;
  }

  std::uint64_t seed_;
  const Parameters& configured_;
  std::map<std::string, KnownDrive> drives_;
  std::map<std::string, std::vector<OdometryUpdate>> odometry_;
};

CalibrationOutcome calibrateOnce(const Prepared& prepared, Drives& drives, std::uint64_t seed) {
  const KnownDrive& drive = drives.drive(prepared.what);
  const double delay = delayOf(prepared.what.laser, seed);
  Follower follower(prepared, drive, delay);
  CalibrationOutcome outcome =
      follower.follow(drives.odometry(prepared), laserPoses(drive, prepared.what.laser, delay, seed));
  if (!prepared.what.loop.empty())
    outcome.loop = driveLoop(prepared.configured, outcome.estimate, drives.loop(prepared.what));
  return outcome;
}

}  // namespace

double CalibrationResult::mean(const std::function<double(const CalibrationOutcome&)>& value) const {
  double sum = 0.0;
  for (const CalibrationOutcome& run : runs) sum += value(run);
  return sum / static_cast<double>(runs.size());
}

std::size_t CalibrationResult::count(const std::function<bool(const CalibrationOutcome&)>& holds) const {
  return static_cast<std::size_t>(std::count_if(runs.begin(), runs.end(), holds));
}

double CalibrationResult::ratio(std::size_t parameter) const {
  const auto i = static_cast<Index>(parameter);
  return std::sqrt(mean([i](const CalibrationOutcome& run) { return run.error(i) * run.error(i); })) /
         bound(i);
}

double CalibrationResult::worstRatio() const {
  double worst = 0.0;
  for (const std::size_t parameter : estimated) worst = std::max(worst, ratio(parameter));
  return worst;
}

double CalibrationResult::worstBias() const {
  double worst = 0.0;
  for (const std::size_t parameter : estimated) {
    const auto i = static_cast<Index>(parameter);
    worst = std::max(worst,
                     std::abs(mean([i](const CalibrationOutcome& run) { return run.error(i); })) / bound(i));
  }
  return worst;
}

double CalibrationResult::meanNis() const {
  double sum = 0.0;
  double updates = 0.0;
  for (const CalibrationOutcome& run : runs) {
    sum += run.mean_nis * static_cast<double>(run.updates);
    updates += static_cast<double>(run.updates);
  }
  return sum / updates;
}

bool CalibrationResult::isLost(const CalibrationOutcome& run, double bounds) const {
  return std::any_of(estimated.begin(), estimated.end(), [&](std::size_t parameter) {
    const auto i = static_cast<Index>(parameter);
    return !(std::abs(run.error(i)) <= bounds * bound(i));
  });
}

bool isFlagged(const CalibrationOutcome& run) {
  const auto seconds = static_cast<double>(run.updates) / kPosesASecond;
  return run.worst_second_nis > meanBelow(3.0, kPosesASecond, 1.0 - (1.0 - kConfidence) / seconds);
}

std::vector<CalibrationResult> studyCalibration(const CalibrationStudySettings& settings) {
  if (settings.runs == 0 || settings.cases.empty())
    throw std::invalid_argument("a study needs drives and cases");
  std::vector<Prepared> prepared;
  std::vector<CalibrationResult> results;
  for (const CalibrationCase& what : settings.cases) {
    prepared.push_back(prepare(what, settings.configured));
    const Prepared& last = prepared.back();
    results.push_back(
        {what, last.estimated, last.bounds.back(), std::vector<CalibrationOutcome>(settings.runs)});
  }
  runInParallel(
      settings.runs, settings.threads,
      [&](std::size_t run) {
        const std::uint64_t seed = settings.seed + run;
        Drives drives(seed, settings.configured);
        for (std::size_t k = 0; k < prepared.size(); ++k)
          results[k].runs[run] = calibrateOnce(prepared[k], drives, seed);
      },
      settings.progress);
  return results;
}

}  // namespace bs_car_odometry::laboratory
