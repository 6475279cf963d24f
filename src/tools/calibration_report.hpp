#pragma once

#include "calibration_findings.hpp"

#include "bs_car_odometry/calibration/atomic_file.hpp"

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// A table of numbers that grows row by row; appears under its name only with commit().
class CsvWriter {
 public:
  /// @throws InputError
  CsvWriter(const std::string& path, const std::vector<std::string>& columns);

  CsvWriter& add(double value);
  CsvWriter& add(Time stamp);  ///< seconds, to the nanosecond
  CsvWriter& add(const Pose2& pose);
  void endRow();
  void commit();  ///< @throws InputError when the disk is full

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void separate();

  calibration::AtomicFile output_;
  std::unique_ptr<std::FILE, Close> file_;
  bool row_begun_{false};
};

/// DIR/updates.csv: everything after each update of the filter, as it goes.
class UpdatesTable {
 public:
  /// Makes the folder. @throws InputError
  explicit UpdatesTable(const std::string& folder);

  void add(const calibration::CalibrationUpdate& update);
  void commit() { csv_.commit(); }

 private:
  CsvWriter csv_;
};

/// What calibrate_bag has found, for summary.json.
struct CalibrationSummary {
  bool good{false};
  std::string verdict;  ///< a sentence
  std::string file;     ///< text of the calibration file; empty when none was written
};

/// The rest of the report, and the figures and pages that scripts/plot_calibration makes of it. A missing
/// matplotlib is a warning.
/// @throws InputError when the folder cannot be written
void writeReport(const std::string& folder, bool pdf, const Findings& findings,
                 const CalibrationSummary& summary);

}  // namespace bs_car_odometry::tools
