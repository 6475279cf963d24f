#include "bs_car_odometry/calibration/refinement.hpp"

#include "fit.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::calibration {

Refinement refine(const Drives& drives, const Parameters& parameters, const RefinementOptions& options) {
  Fit fit(drives, parameters, options);
  fit.run();
  return fit.result();
}

std::vector<Disagreement> disagreements(const FilterEstimate& filter, const Refinement& refined) {
  std::vector<Disagreement> found;
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!refined.estimated[i]) continue;
    const double difference = refined.values[k] - filter.values[k];
    const double deviation = std::sqrt(std::max(filter.covariance(k, k), refined.covariance(k, k)));
    if (std::abs(difference) > deviation) found.push_back({i, difference, deviation});
  }
  return found;
}

}  // namespace bs_car_odometry::calibration
