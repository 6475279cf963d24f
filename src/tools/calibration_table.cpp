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

std::string fileName(const std::string& path) { return path.substr(path.rfind('/') + 1); }

int nameWidth(const FilteredBags& filtered) {
  std::size_t width = 10;
  for (const CalibratedBag& bag : filtered.bags) width = std::max(width, fileName(bag.path).size());
  return static_cast<int>(std::min<std::size_t>(width, 60));
}

}  // namespace

std::string dataTable(const FilteredBags& filtered) {
  const int width = nameWidth(filtered);
  std::string text = line("%-*s %12s %12s %9s", width, "bag", "distance", "laser poses", "rejected");
  for (const CalibratedBag& bag : filtered.bags) {
    const auto rejected = std::count(bag.good.begin(), bag.good.end(), false);
    text += line("%-*s %10.1f m %12zu %9zd", width, fileName(bag.path).c_str(), bag.distance, bag.good.size(),
                 rejected);
  }
  text += line("mean NIS %.2f of the poses that were not rejected; 3 is expected", filtered.mean_nis);
  return text;
}

std::string parameterTable(const FilteredBags& filtered) {
  std::string text = line("%-22s %12s %12s %10s  %s", "parameter", "value", "deviation", "prior", "observed");
  for (std::size_t i = 0; i < kCount; ++i) {
    if (!filtered.estimated[i]) continue;
    const auto k = static_cast<Eigen::Index>(i);
    text += line("%-22s %12.6f %12.6f %10.4g  %s", parameterName(i).c_str(), filtered.estimate.values[k],
                 std::sqrt(filtered.estimate.covariance(k, k)), filtered.prior[k],
                 filtered.observed[i] ? "yes" : "no");
  }
  return text;
}

std::string driftTable(const FilteredBags& filtered, const std::vector<BagPaths>& paths) {
  const int width = nameWidth(filtered);
  std::string text = line("%-*s %12s %20s %20s", width, "end drift", "distance", "before", "after");
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const EndDrift before = endDriftOf(paths[i].before);
    const EndDrift after = endDriftOf(paths[i].after);
    text += line("%-*s %10.1f m %9.3f m (%5.2f %%) %9.3f m (%5.2f %%)", width,
                 fileName(filtered.bags[i].path).c_str(), after.distance, before.error, before.percent(),
                 after.error, after.percent());
  }
  return text;
}

}  // namespace bs_car_odometry::tools
