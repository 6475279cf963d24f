#include "bs_car_odometry/calibration/refinement.hpp"

#include "fit.hpp"
#include "path_fit.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::calibration {

namespace {

std::vector<Disagreement> disagreements(const ParameterMask& estimated, const ParameterVector& first,
                                        const ParameterMatrix& first_covariance,
                                        const ParameterVector& second,
                                        const ParameterMatrix& second_covariance) {
  std::vector<Disagreement> found;
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!estimated[i]) continue;
    const double difference = second[k] - first[k];
    const double deviation = std::sqrt(std::max(first_covariance(k, k), second_covariance(k, k)));
    if (std::abs(difference) > deviation) found.push_back({i, difference, deviation});
  }
  return found;
}

}  // namespace

Refinement refine(const Drives& drives, const Parameters& parameters, const RefinementOptions& options) {
  Fit fit(drives, parameters, options);
  fit.run();
  Refinement refined = fit.result();
  if (options.objective == Objective::kPath && refined.converged)
    return fitPath(drives, parameters, refined, fit.chainOptions());
  return refined;
}

std::vector<Disagreement> disagreements(const FilterEstimate& filter, const Refinement& refined) {
  return disagreements(refined.estimated, filter.values, filter.covariance, refined.values,
                       refined.covariance);
}

std::vector<Disagreement> disagreements(const Refinement& likelihood, const Refinement& path) {
  return disagreements(path.estimated, likelihood.values, likelihood.covariance, path.values,
                       path.covariance);
}

}  // namespace bs_car_odometry::calibration
