#include "ratio_reporter.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>

namespace bs_car_odometry::benchmarks {

void RatioReporter::ReportRuns(const std::vector<Run>& runs) {
  for (const Run& run : runs)
    if (run.aggregate_name == "median") medians_[run.run_name.function_name] = run.GetAdjustedCPUTime();
  ConsoleReporter::ReportRuns(runs);
}

void RatioReporter::printRatio(const std::string& name, const std::vector<std::string>& others) const {
  double fastest = std::numeric_limits<double>::infinity();
  for (const std::string& other : others) {
    const auto found = medians_.find(other);
    if (found != medians_.end()) fastest = std::min(fastest, found->second);
  }
  const auto found = medians_.find(name);
  if (found == medians_.end() || fastest == std::numeric_limits<double>::infinity()) return;
  std::printf("ratio of medians %s / MRPT: %.3f (%.1f ns / %.1f ns)\n", name.c_str(), found->second / fastest,
              found->second, fastest);
}

}  // namespace bs_car_odometry::benchmarks
