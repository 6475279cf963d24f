#include "bs_car_odometry/laboratory/chi_square.hpp"

#include <boost/math/distributions/chi_squared.hpp>

#include <cmath>

namespace bs_car_odometry::laboratory {

using boost::math::chi_squared;
using boost::math::quantile;

std::array<double, 3> sigmaShares() {
  return {std::erf(1.0 / std::sqrt(2.0)), std::erf(2.0 / std::sqrt(2.0)), std::erf(3.0 / std::sqrt(2.0))};
}

std::array<double, 3> sigmaRegions(double degrees) {
  const chi_squared distribution(degrees);
  std::array<double, 3> regions{};
  for (std::size_t k = 0; k < regions.size(); ++k) regions[k] = quantile(distribution, sigmaShares()[k]);
  return regions;
}

Interval meanInterval(double degrees, std::size_t count) {
  const auto n = static_cast<double>(count);
  const chi_squared sum(degrees * n);
  const double tail = 0.5 * (1.0 - kConfidence);
  return {quantile(sum, tail) / n, quantile(sum, 1.0 - tail) / n};
}

double meanBelow(double degrees, std::size_t count, double probability) {
  const auto n = static_cast<double>(count);
  return quantile(chi_squared(degrees * n), probability) / n;
}

}  // namespace bs_car_odometry::laboratory
