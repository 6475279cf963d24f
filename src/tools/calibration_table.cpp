#include "calibration_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace bs_car_odometry::tools {

using namespace calibration;

namespace {

/// A line as printf makes it.
__attribute__((format(printf, 1, 2))) std::string line(const char* format, ...) {
  std::array<char, 512> text{};
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  return std::string(text.data()) + "\n";
}

int nameWidth(const FilteredBags& filtered) {
  std::size_t width = 10;
  for (const CalibratedBag& bag : filtered.bags) width = std::max(width, bag.name().size());
  return static_cast<int>(std::min<std::size_t>(width, 60));
}

std::string driftCell(const Drift& drift) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), " %9.3f m (%5.2f %%)", drift.error, drift.percent());
  return text.data();
}

std::string noiseLine(const char* name, const NoiseLevel& level) {
  if (!level.found)
    return line("%-22s %12.6g as configured: the drives do not show it", name, level.configured);
  return line("%-22s %12.6g %12.2g  configured %.4g", name, level.value, level.deviation, level.configured);
}

std::string noiseLines(const Findings& findings) {
  if (!findings.noise) return {};
  const NoiseLevels& noise = *findings.noise;
  if (!noise.converged) return line("%-22s not found: what is configured holds", "noise");
  return noiseLine("noise/wheel", noise.wheel) + noiseLine("laser, position [m]", noise.laser_position) +
         noiseLine("laser, yaw [rad]", noise.laser_yaw) +
         line("%-22s %11.1f %%", "laser, outliers", 100.0 * noise.outliers);
}

}  // namespace

std::string dataTable(const FilteredBags& filtered) {
  const int width = nameWidth(filtered);
  std::string text = line("%-*s %12s %12s %9s", width, "bag", "distance", "laser poses", "rejected");
  for (const CalibratedBag& bag : filtered.bags) {
    const auto rejected = std::count(bag.good.begin(), bag.good.end(), false);
    text +=
        line("%-*s %10.1f m %12zu %9zd", width, bag.name().c_str(), bag.distance, bag.good.size(), rejected);
  }
  text += line("mean NIS %.2f of the poses that were not rejected; 3 is expected", filtered.mean_nis);
  return text;
}

std::string parameterTable(const Findings& findings) {
  const bool refined = findings.refined.has_value();
  std::string text = line("%-22s %12s %12s %10s  %-8s%s", "parameter", "value", "deviation", "prior",
                          "observed", refined ? "      filter    deviation" : "");
  for (std::size_t i = 0; i < kCount; ++i) {
    if (!findings.estimated()[i]) continue;
    const auto k = static_cast<Eigen::Index>(i);
    const FilterEstimate& filter = findings.filtered.estimate;
    std::array<char, 64> filtered{};
    if (refined)
      std::snprintf(filtered.data(), filtered.size(), " %12.6f %12.6f", filter.values[k],
                    std::sqrt(filter.covariance(k, k)));
    text += line("%-22s %12.6f %12.6f %10.4g  %-8s%s", parameterName(i).c_str(), findings.values[k],
                 findings.deviation(i), findings.filtered.prior[k], findings.observed[i] ? "yes" : "no",
                 filtered.data());
  }
  return text + noiseLines(findings);
}

std::string driftTable(const Findings& findings) {
  const int width = nameWidth(findings.filtered);
  const bool left_out = !findings.left_out.empty();
  std::string text = line("%-*s %12s %20s %20s%s", width, "end drift", "distance", "before", "after",
                          left_out ? "     by the other bags" : "");
  for (std::size_t i = 0; i < findings.paths.size(); ++i) {
    const BagPaths& paths = findings.paths[i];
    const Drift before = driftOf(paths.before);
    const Drift after = driftOf(paths.after);
    text += line("%-*s %10.1f m%s%s%s", width, findings.filtered.bags[i].name().c_str(), after.distance,
                 driftCell(before).c_str(), driftCell(after).c_str(),
                 left_out ? driftCell(findings.left_out[i].calibrated).c_str() : "");
  }
  return text;
}

}  // namespace bs_car_odometry::tools
