#include "noise_fit.hpp"

#include "independent_spread.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <utility>

namespace bs_car_odometry::tools {

namespace {

constexpr int kMostRounds = 8;
constexpr double kLikelihoodStands = 0.2;  // change of the logarithm
constexpr double kNoiseStands = 0.01;      // relative
constexpr double kSmallShare = 1e-3;       // of the start, where another fit found nothing

bool all(std::size_t /*run*/) { return true; }

/// Number of a name, new ones added.
std::size_t numberOf(const std::string& name, std::vector<std::string>& names) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  names.push_back(name);
  return names.size() - 1;
}

Eigen::VectorXd rootsOf(const VarianceFit& fit) { return fit.variances.cwiseSqrt(); }

/// True when linearising again has changed next to nothing. Gains do not count by themselves: some may hardly
/// be told apart, such as those of two axles, and wander without any effect.
bool stands(const VarianceFit& fit, const VarianceFit& before) {
  const Eigen::VectorXd change = (rootsOf(fit) - rootsOf(before)).cwiseAbs();
  return std::abs(fit.log_likelihood - before.log_likelihood) < kLikelihoodStands &&
         (change.array() <= kNoiseStands * rootsOf(fit).array()).all();
}

}  // namespace

LinearisedRuns::LinearisedRuns(const std::vector<RecordedRun>& runs, const Parameters& parameters,
                               const NoiseFitSettings& settings)
    : runs_(runs), nominal_(parameters), settings_(settings) {
  if (runs.empty()) throw InputError("no runs to find noise from");
  for (const RecordedRun& run : runs) {
    wheels_of_.push_back(numberOf(run.wheels, wheels_));
    recording_of_.push_back(numberOf(run.wheels + '\n' + run.recording, recordings_));
  }
  unknowns_ = noiseUnknowns(parameters, settings_.noise.empty() ? defaultNoise() : settings_.noise);
  parameters_.assign(wheels_.size(), parameters);
  draws_.assign(recordings_.size(), Eigen::VectorXd::Zero(static_cast<Eigen::Index>(unknowns_.gains.size())));
  start_.resize(static_cast<Eigen::Index>(unknowns_.path.size() + unknowns_.systematic.size()));
  Eigen::Index i = 0;
  for (const std::vector<UnknownNoise>* sought : {&unknowns_.path, &unknowns_.systematic})
    for (const UnknownNoise& noise : *sought)
      start_[i++] = std::pow(std::max(noise.value(nominal_.noise).std(), noise.least), 2);
}

/// What the drives can tell: how recordings on the same wheels differ only where there are several.
std::vector<std::string> LinearisedRuns::defaultNoise() const {
  std::vector<std::string> names{"noise/wheel"};
  if (recordings_.size() < wheels_.size() + 2) return names;
  for (const char* gain : {"k_r", "k_l", "k_b"}) names.push_back(std::string("noise/systematic/") + gain);
  return names;
}

void LinearisedRuns::linearise(const std::function<void()>& progress) {
  errors_.clear();
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    errors_.push_back(linearised(i));
    progress();
  }
}

/// About the gains of the run's own recording, where first order is good; then as seen from the gains of its
/// wheels.
DriveErrors LinearisedRuns::linearised(std::size_t run) const {
  const Eigen::VectorXd& draw = draws_[recording_of_[run]];
  Parameters parameters = parameters_[wheels_of_[run]];
  for (std::size_t j = 0; j < unknowns_.gains.size(); ++j)
    unknowns_.gains[j].value(parameters) += draw[static_cast<Eigen::Index>(j)];
  DriveErrors errors = driveErrors(runs_[run].drive, parameters, unknowns_, settings_.errors);
  errors.path.error += errors.path.sensitivity * draw;
  const Eigen::Vector3d at_end = errors.end.sensitivity * draw;
  errors.end.error += at_end;
  errors.odometry.x -= at_end.x();
  errors.odometry.y -= at_end.y();
  errors.odometry.yaw -= at_end.z();
  return errors;
}

/// Of what the gains lack: the prior is about the vehicle file's values.
GainPrior LinearisedRuns::priorOf(std::size_t wheels) const {
  const auto p = static_cast<Eigen::Index>(unknowns_.gains.size());
  GainPrior prior{Eigen::VectorXd(p), Eigen::VectorXd(p)};
  Parameters nominal = nominal_;
  Parameters now = parameters_[wheels];
  for (Eigen::Index j = 0; j < p; ++j) {
    const UnknownGain& gain = unknowns_.gains[static_cast<std::size_t>(j)];
    prior.mean[j] = gain.value(nominal) - gain.value(now);
    prior.variance[j] = gain.prior * gain.prior;
  }
  return prior;
}

VarianceComponents LinearisedRuns::model(const std::function<bool(std::size_t)>& uses) const {
  std::vector<GroupedDrive> drives;
  for (std::size_t i = 0; i < errors_.size(); ++i)
    if (uses(i)) drives.push_back({&errors_[i].path, wheels_of_[i], recording_of_[i]});
  std::vector<GainPrior> priors;
  for (std::size_t i = 0; i < wheels_.size(); ++i) priors.push_back(priorOf(i));
  std::vector<int> draws;
  for (const UnknownGain& gain : unknowns_.gains) {
    const auto varies = [&](const UnknownNoise& noise) { return noise.name == gain.systematic; };
    const auto found = std::find_if(unknowns_.systematic.begin(), unknowns_.systematic.end(), varies);
    draws.push_back(
        found == unknowns_.systematic.end() ? -1 : static_cast<int>(found - unknowns_.systematic.begin()));
  }
  return {std::move(drives), std::move(priors), std::move(draws)};
}

VarianceFit LinearisedRuns::fit(const std::function<bool(std::size_t)>& uses,
                                const Eigen::VectorXd& guess) const {
  const VarianceComponents components = model(uses);
  // A variance of zero says nothing of where other runs would have it.
  const Eigen::VectorXd start = guess.cwiseMax(kSmallShare * start_);
  return fitVariances([&](const Eigen::VectorXd& v) { return components.logLikelihood(v); }, start);
}

void LinearisedRuns::adopt(const VarianceFit& fit) {
  const VarianceComponents components = model(all);
  const std::vector<GainEstimate> gains = components.gains(fit.variances);
  for (const auto& [recording, draw] : components.recordingDraws(fit.variances)) draws_[recording] = draw;
  for (std::size_t i = 0; i < wheels_.size(); ++i) {
    for (std::size_t j = 0; j < unknowns_.gains.size(); ++j)
      unknowns_.gains[j].value(parameters_[i]) += gains[i].mean[static_cast<Eigen::Index>(j)];
    for (std::size_t k = 0; k < unknowns_.path.size(); ++k)
      unknowns_.path[k].value(parameters_[i].noise) = std::sqrt(fit.variances[static_cast<Eigen::Index>(k)]);
  }
}

std::vector<std::pair<std::string, double>> LinearisedRuns::nextDrive(
    const VarianceFit& fit, const std::vector<GainEstimate>& gains, const Eigen::VectorXd& systematic) const {
  std::vector<std::string> names;
  std::vector<std::size_t> keys;
  for (const UnknownGain& gain : unknowns_.gains) keys.push_back(numberOf(gain.systematic, names));
  std::vector<GainEffect> effects;
  for (std::size_t i = 0; i < errors_.size(); ++i) {
    const LinearDrive& end = errors_[i].end;
    const Eigen::LLT<Eigen::MatrixXd> others(end.covariance(fit.variances));
    Eigen::MatrixXd covariance = gains[wheels_of_[i]].covariance;
    covariance.diagonal() += systematic;
    effects.push_back({others.matrixL().solve(end.sensitivity), covariance});
  }
  const Eigen::VectorXd variances = independentVariances(effects, keys);
  std::vector<std::pair<std::string, double>> values;
  for (std::size_t k = 0; k < names.size(); ++k)
    values.emplace_back(names[k], std::sqrt(variances[static_cast<Eigen::Index>(k)]));
  return values;
}

NoiseFit LinearisedRuns::describe(const VarianceFit& fit) const {
  NoiseFit result;
  Eigen::Index i = 0;
  for (const std::vector<UnknownNoise>* sought : {&unknowns_.path, &unknowns_.systematic})
    for (const UnknownNoise& noise : *sought) {
      result.noise.push_back({noise.name, std::sqrt(fit.variances[i]), fit.std_of_roots[i]});
      ++i;
    }
  for (const UnknownGain& gain : unknowns_.gains) result.gain_names.push_back(gain.name);
  const VarianceComponents components = model(all);
  const std::vector<GainEstimate> estimates = components.gains(fit.variances);
  const Eigen::VectorXd systematic = components.systematicVariances(fit.variances);
  for (std::size_t w = 0; w < wheels_.size(); ++w) {
    Eigen::VectorXd value = estimates[w].mean;
    Parameters now = parameters_[w];
    for (std::size_t j = 0; j < unknowns_.gains.size(); ++j)
      value[static_cast<Eigen::Index>(j)] += unknowns_.gains[j].value(now);
    const Eigen::VectorXd next = (estimates[w].covariance.diagonal() + systematic).cwiseSqrt();
    result.gains.push_back({wheels_[w], value, estimates[w].covariance, next});
  }
  result.next_drive = nextDrive(fit, estimates, systematic);
  result.log_likelihood = fit.log_likelihood;
  result.runs = runs_.size();
  result.recordings = recordings_.size();
  const Eigen::Index rows = settings_.errors.headings ? 3 : 2;
  for (const DriveErrors& errors : errors_) {
    result.places += static_cast<std::size_t>(errors.path.error.size() / rows);
    result.distance += errors.distance;
  }
  return result;
}

std::pair<LinearisedRuns, VarianceFit> linearisedFit(const std::vector<RecordedRun>& runs,
                                                     const Parameters& parameters,
                                                     const NoiseFitSettings& settings) {
  LinearisedRuns linearised(runs, parameters, settings);
  Progress progress("finding the noise", static_cast<double>(3 * runs.size()));
  double done = 0.0;
  const auto count = [&] { progress.update(++done); };
  linearised.linearise(count);
  VarianceFit fit = linearised.fit(all);
  for (int round = 0; round < kMostRounds; ++round) {
    linearised.adopt(fit);
    linearised.linearise(count);
    VarianceFit next = linearised.fit(all);
    const bool settled = stands(next, fit);
    fit = std::move(next);
    if (settled) return {std::move(linearised), std::move(fit)};
  }
  throw InputError("noise and gains do not settle: is the truth of these drives the truth of this vehicle?");
}

NoiseFit fitNoise(const std::vector<RecordedRun>& runs, const Parameters& parameters,
                  const NoiseFitSettings& settings) {
  const auto [linearised, fit] = linearisedFit(runs, parameters, settings);
  return linearised.describe(fit);
}

}  // namespace bs_car_odometry::tools
