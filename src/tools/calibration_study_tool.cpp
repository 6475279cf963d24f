#include "calibration_study_tool.hpp"

#include "bs_car_odometry/calibration/atomic_file.hpp"
#include "bs_car_odometry/laboratory/calibration_targets.hpp"
#include "tool.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace bs_car_odometry::tools {

namespace {

namespace po = boost::program_options;
using laboratory::CalibrationTarget;
using laboratory::TargetRow;

struct Request {
  std::string config;
  std::vector<std::string> settings;
  std::vector<int> targets;
  std::size_t runs{200};
  std::uint64_t seed{1};
  unsigned threads{0};
  std::string csv;
};

po::options_description optionsFor(Request& request) {
  po::options_description options("options");
  auto add = options.add_options();
  add("config", po::value(&request.config)->required(), "vehicle file");
  add("set", po::value(&request.settings)->composing(), "parameter=value, instead of the vehicle file's");
  add("target", po::value(&request.targets)->composing(),
      "1 to 9, several times for several; all without it");
  add("runs", po::value(&request.runs)->default_value(request.runs), "drives of each case");
  add("seed", po::value(&request.seed)->default_value(request.seed), "of the first drive; each has the next");
  add("threads", po::value(&request.threads)->default_value(0), "0: one for each processor");
  add("csv", po::value(&request.csv), "write the figures here too");
  return options;
}

Request parse(int argc, const char* const* argv) {
  Request request;
  const std::string usage =
      "calibration_study --config VEHICLE.yaml [options]\n\n"
      "Calibrations of simulated drives against what is mathematically possible (docs/calibration.md, 5): "
      "one\n"
      "line for each figure, as Markdown. Ends with 0 when all are as wanted, with 1 when one is not.";
  parseCommandLine(argc, argv, usage, optionsFor(request));
  const auto check = [](bool holds, const std::string& rule) {
    if (!holds) throw InputError(rule);
  };
  check(request.runs >= 2 && request.runs <= 1000000, "--runs must be from 2 to 1000000");
  check(request.threads <= 1024, "--threads must be at most 1024");
  for (const int target : request.targets) check(target >= 1 && target <= 9, "--target must be from 1 to 9");
  return request;
}

std::vector<CalibrationTarget> targetsOf(const Request& request) {
  std::vector<CalibrationTarget> targets;
  for (const CalibrationTarget target : laboratory::allCalibrationTargets()) {
    const bool asked =
        std::count(request.targets.begin(), request.targets.end(), static_cast<int>(target)) > 0;
    if (asked || request.targets.empty()) targets.push_back(target);
  }
  return targets;
}

std::string text(double value) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.4g", value);
  return buffer.data();
}

void writeTable(std::ostream& out, std::size_t runs, const std::vector<TargetRow>& rows) {
  out << runs << " drives each.\n\n"
      << "| target | drive | axles | figure | measured | wanted | |\n"
      << "| --- | --- | --- | --- | --- | --- | --- |\n";
  for (const TargetRow& row : rows)
    out << "| " << static_cast<int>(row.target) << " | " << row.drive << " | " << row.axles << " | "
        << row.what << " | " << text(row.measured) << " | " << row.wanted << " | "
        << (row.met ? "ok" : "FAIL") << " |\n";
  out.flush();
}

void writeCsv(std::ostream& out, const std::vector<TargetRow>& rows) {
  out << "target,drive,axles,figure,measured,wanted,met\n";
  for (const TargetRow& row : rows)
    out << static_cast<int>(row.target) << ',' << row.drive << ',' << row.axles << ",\"" << row.what << "\","
        << text(row.measured) << ',' << row.wanted << ',' << (row.met ? 1 : 0) << '\n';
}

}  // namespace

bool calibrationStudy(int argc, const char* const* argv) {
  const Request request = parse(argc, argv);
  laboratory::CalibrationStudySettings study;
  study.configured = loadNominalVehicle({request.config}, request.settings);
  study.runs = request.runs;
  study.seed = request.seed;
  study.threads = request.threads;
  // Before the drives: a folder that is missing should not cost an hour.
  std::optional<calibration::AtomicFile> csv;
  if (!request.csv.empty()) csv.emplace(request.csv);
  Progress progress("calibration_study", static_cast<double>(request.runs));
  study.progress = [&](std::size_t runs) { progress.update(static_cast<double>(runs)); };
  const std::vector<TargetRow> rows = laboratory::judgeCalibration(study, targetsOf(request));
  progress.hide();
  writeTable(std::cout, request.runs, rows);
  if (csv) {
    std::ofstream file(csv->temporaryPath());
    writeCsv(file, rows);
    file.close();
    if (!file) throw InputError("cannot write " + csv->temporaryPath());
    csv->commit();
  }
  return std::all_of(rows.begin(), rows.end(), [](const TargetRow& row) { return row.met; });
}

}  // namespace bs_car_odometry::tools
