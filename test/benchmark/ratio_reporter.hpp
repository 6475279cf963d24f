#pragma once

#include <benchmark/benchmark.h>

#include <map>
#include <string>
#include <vector>

namespace bs_car_odometry::benchmarks {

/// Prints as usual and keeps the median of every benchmark's repetitions.
class RatioReporter : public benchmark::ConsoleReporter {
 public:
  RatioReporter() : ConsoleReporter(OO_Tabular) {}

  void ReportRuns(const std::vector<Run>& runs) override;

  /// `name`'s median over the fastest of `others`; prints nothing where one of them was not run.
  void printRatio(const std::string& name, const std::vector<std::string>& others) const;

 private:
  std::map<std::string, double> medians_;  ///< [ns] of CPU time
};

}  // namespace bs_car_odometry::benchmarks
