#include "calibration_findings.hpp"

#include "calibrate.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <cmath>
#include <utility>

namespace bs_car_odometry::tools {

using namespace calibration;

namespace {

/// Takes values and their covariance, and what they mean.
/// @throws InputError where a gain tells of a wrong vehicle file
void take(const ParameterVector& values, const ParameterMatrix& covariance, Findings& findings) {
  findings.values = values;
  findings.covariance = covariance;
  const Knowledge knowledge = findings.knowledge();
  for (std::size_t i = 0; i < kCount; ++i) findings.observed[i] = knowledge.observed(i);
  const std::string implausible = implausibleGains(values, findings.observed);
  if (!implausible.empty()) throw InputError(implausible + "; nothing was written");
}

std::string differences(const std::vector<Disagreement>& disagreements) {
  std::vector<std::string> names;
  names.reserve(disagreements.size());
  for (const Disagreement& disagreement : disagreements)
    names.push_back(parameterName(disagreement.parameter));
  return listed(names);
}

void warnOfDifferences(const FilterEstimate& filter, const Refinement& likelihood) {
  const std::vector<Disagreement> found = disagreements(filter, likelihood);
  if (!found.empty())
    warn("filter and fit differ by more than their standard deviations in " + differences(found) +
         ": is the noise right, and were the gains far off at first?");
}

/// The same drives by the other objective, beginning with what the likelihood has found.
Refinement leastDrift(const Drives& drives, const Parameters& parameters, const Refinement& likelihood,
                      RefinementOptions& options) {
  options.objective = Objective::kPath;
  options.seed = likelihood.values;
  Refinement path = refine(drives, parameters, options);
  const std::vector<Disagreement> found = disagreements(likelihood, path);
  if (path.converged && !found.empty())
    warn("likelihood and path differ by more than their standard deviations in " + differences(found) +
         ": part of the drift is not noise");
  return path;
}

NoResultError notConverged() {
  return {kNotConvergedStatus,
          "the fit of all readings at once did not converge; look at --report with --no-refine, "
          "and at the bags with bag_doctor; nothing was written"};
}

/// Noise first, since the fit's weights and covariance stand on it.
void refineFindings(Findings& findings, Objective objective) {
  const Parameters& parameters = findings.filtered.parameters;
  Drives drives;
  for (const CalibratedBag& bag : findings.filtered.bags)
    if (!bag.drive.lasers().empty()) drives.push_back(&bag.drive);  // not a run by tape
  RefinementOptions options;
  options.seed = findings.filtered.estimate.values;
  const NoiseLevels noise = estimateNoise(drives, parameters, options);
  if (noise.converged) options.laser_scales = noise.laserScales();
  const Parameters used = noise.converged ? withNoise(noise, parameters) : parameters;
  if (!noise.converged) warn("the noise levels were not found: those configured hold");
  findings.noise = noise;
  Refinement refined = refine(drives, used, options);
  if (!refined.converged && !namesOf(findings.notObserved(), true).empty()) {
    // A gain that no drive shows may be anything: no reason to doubt what the filter has found of the others.
    warn("the fit of all readings at once did not converge: the filter's values hold");
    return;
  }
  if (!refined.converged) throw notConverged();
  warnOfDifferences(findings.filtered.estimate, refined);
  if (objective == Objective::kPath) refined = leastDrift(drives, used, refined, options);
  if (!refined.converged) throw notConverged();
  take(refined.values, refined.covariance, findings);
  if (drives.size() > 1 && drives.size() == findings.filtered.bags.size())
    findings.left_out = leaveOneOut(drives, used, refined, options);
  findings.refined = std::move(refined);
  findings.objective = objective;
}

std::vector<std::string> bagNames(const FilteredBags& filtered) {
  std::vector<std::string> names;
  for (const CalibratedBag& bag : filtered.bags) names.push_back(bag.name());
  return names;
}

}  // namespace

double Findings::deviation(std::size_t parameter) const {
  const auto k = static_cast<Eigen::Index>(parameter);
  return std::sqrt(covariance(k, k));
}

ParameterMask Findings::notObserved() const {
  ParameterMask mask{};
  for (std::size_t i = 0; i < kCount; ++i) mask[i] = filtered.estimated[i] && !observed[i];
  return mask;
}

Knowledge Findings::knowledge() const {
  return {filtered.estimated, filtered.prior, covariance.diagonal().cwiseMax(0.0).cwiseSqrt(),
          filtered.excitation};
}

std::vector<std::string> namesOf(const ParameterMask& mask, bool gains_only) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kCount; ++i)
    if (mask[i] && (isGain(i) || !gains_only)) names.push_back(parameterName(i));
  return names;
}

Findings findingsOf(FilteredBags filtered, const CalibrateOptions& options) {
  Findings findings;
  findings.filtered = std::move(filtered);
  take(findings.filtered.estimate.values, findings.filtered.estimate.covariance, findings);
  if (options.refine) refineFindings(findings, options.objective);
  const Parameters& parameters = findings.filtered.parameters;
  const ParameterVector configured = valuesOf(parameters);
  for (const CalibratedBag& bag : findings.filtered.bags)
    findings.paths.push_back({deadReckon(bag.drive, parameters, configured, bag.good),
                              deadReckon(bag.drive, parameters, findings.values, bag.good)});
  return findings;
}

CalibrationResult resultOf(const Findings& findings) {
  const FilteredBags& filtered = findings.filtered;
  CalibrationResult result;
  result.values = findings.values;
  result.covariance = findings.covariance;
  result.listed = findings.observed;
  result.not_observed = findings.notObserved();
  result.data.bags = bagNames(filtered);
  result.data.from = toRos(filtered.span.begin).toSec();
  result.data.to = toRos(filtered.span.end).toSec();
  result.data.distance = filtered.excitation.distance;
  result.data.laser_poses = filtered.counts.used;
  result.data.rejected = filtered.counts.rejected;
  if (findings.refined)
    result.data.objective = findings.objective == Objective::kPath ? "path" : "likelihood";
  return result;
}

}  // namespace bs_car_odometry::tools
