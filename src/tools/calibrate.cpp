#include "calibrate.hpp"

#include "calibrate_options.hpp"
#include "calibration_findings.hpp"
#include "calibration_report.hpp"
#include "calibration_table.hpp"

#include "bs_car_odometry/calibration/result_file.hpp"

#include <iostream>
#include <optional>

namespace bs_car_odometry::tools {

using namespace calibration;

namespace {

/// Why the gains cannot be saved, and what to drive; empty when they can.
std::string whyNotSaved(const Findings& findings) {
  const std::string reason = whyNotAllObserved(findings.knowledge());
  const bool partial = findings.filtered.parameters.calibration.allow_partial;
  if (reason.empty() || (partial && !namesOf(findings.observed, true).empty())) return {};
  return reason + (partial ? "; nothing was written"
                           : "; nothing was written (calibration/allow_partial=true saves the rest)");
}

/// What the report says above everything else.
CalibrationSummary summaryOf(const Findings& findings, const CalibrationResult& result,
                             const std::string& not_saved) {
  if (!not_saved.empty()) return {false, not_saved, ""};
  const std::vector<std::string> missing = namesOf(findings.notObserved());
  return {missing.empty(),
          missing.empty() ? "Every parameter was observed."
                          : "Saved, but not observed and left as configured: " + listed(missing) + ".",
          toText(result, findings.filtered.parameters)};
}

Findings find(const CalibrateOptions& options) {
  std::optional<UpdatesTable> updates;
  if (!options.report.empty()) updates.emplace(options.report);
  const auto listener = [&updates](const CalibrationUpdate& update) {
    if (updates) updates->add(update);
  };
  FilteredBags filtered = filterBags(options, listener);
  if (updates) updates->commit();
  std::cout << dataTable(filtered) << std::flush;
  return findingsOf(std::move(filtered), options);
}

}  // namespace

void calibrate(int argc, const char* const* argv) {
  const CalibrateOptions options = calibrateOptions(argc, argv);
  checkWritable(options.output);  // rather now than after an hour's bag
  const Findings findings = find(options);
  std::cout << '\n' << parameterTable(findings) << '\n' << driftTable(findings) << std::flush;
  const CalibrationResult result = resultOf(findings);
  const std::string not_saved = whyNotSaved(findings);
  if (not_saved.empty()) writeCalibrationFile(options.output, result, findings.filtered.parameters);
  if (!options.report.empty())
    writeReport(options.report, options.pdf, findings, summaryOf(findings, result, not_saved));
  if (!not_saved.empty()) throw NoResultError(kNotObservedStatus, not_saved);
  std::cout << "\nwritten: " << options.output << std::endl;
}

}  // namespace bs_car_odometry::tools
