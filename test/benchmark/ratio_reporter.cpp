#include "ratio_reporter.hpp"

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
  std::string fastest_name;
  for (const std::string& other : others) {
    const auto found = medians_.find(other);
    if (found == medians_.end() || found->second >= fastest) continue;
    fastest = found->second;
    fastest_name = other;
  }
  const auto found = medians_.find(name);
  if (found == medians_.end() || fastest_name.empty()) return;
  std::printf("ratio of medians %s / %s: %.3f (%.1f ns / %.1f ns)\n", name.c_str(), fastest_name.c_str(),
              found->second / fastest, found->second, fastest);
}

}  // namespace bs_car_odometry::benchmarks
