#include "recorded_consistency_tool.hpp"

#include "noise_report.hpp"
#include "recorded_consistency.hpp"
#include "recorded_folder.hpp"
#include "tool.hpp"

#include "bs_car_odometry/calibration/atomic_file.hpp"

#include <boost/optional.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>

namespace bs_car_odometry::tools {

namespace {

namespace po = boost::program_options;

struct Request {
  std::string folder;
  std::string config;
  std::vector<std::string> settings;
  std::string list;
  std::string entry;
  double longer_than{1.0};
  boost::optional<double> truth_sigma;
  boost::optional<double> truth_yaw_sigma;
  std::string csv;
};

Request parse(int argc, const char* const* argv) {
  Request request;
  po::options_description options("options");
  auto add = options.add_options();
  add("recorded", po::value(&request.folder)->required(),
      "folder whose sub-folders are runs: wheels.csv, pose.csv, perhaps steering.csv; a run called "
      "PATH-RECORDING-NUMBER belongs to the recording PATH-RECORDING");
  add("config", po::value(&request.config)->required(), "vehicle file");
  add("set", po::value(&request.settings)->composing(), "parameter=value, instead of the vehicle file's");
  add("list", po::value(&request.list),
      "YAML file that says how folders are read: options of csv_to_bag, runs on other wheels");
  add("entry", po::value(&request.entry), "of that file (default: the folder's name)");
  add("longer-than", po::value(&request.longer_than)->default_value(1.0), "leave shorter runs out [m]");
  add("truth-sigma", po::value(&request.truth_sigma),
      "standard deviation of a true position [m] (default: laser_sigma/position)");
  add("truth-yaw-sigma", po::value(&request.truth_yaw_sigma),
      "of a true yaw [rad] (default: laser_sigma/yaw)");
  add("csv", po::value(&request.csv), "write every run here");
  parseCommandLine(
      argc, argv,
      "consistency --recorded FOLDER --config VEHICLE.yaml [options]\n\n"
      "The end of every recorded run against gains and noise that were found on the others: once on "
      "all\nother runs, once on those of all other recordings. d2: squared Mahalanobis distance of the "
      "end\nposition; 39 % of the runs lie below 1 and 99.7 % below 11.8 where the covariance is right.",
      options);
  return request;
}

double positive(double value, const std::string& option) {
  if (!(value > 0.0 && value < 1e3)) throw InputError("--" + option + " must be above 0");
  return value;
}

NoiseFitSettings fitSettings(const Request& request, const LaserSigma& sigma) {
  NoiseFitSettings settings;
  settings.errors.truth_position = positive(request.truth_sigma.value_or(sigma.position), "truth-sigma");
  settings.errors.truth_yaw = positive(request.truth_yaw_sigma.value_or(sigma.yaw), "truth-yaw-sigma");
  return settings;
}

RecordedFolderSettings folderSettings(const Request& request) {
  if (request.list.empty()) return {};
  const std::filesystem::path folder = std::filesystem::absolute(request.folder).lexically_normal();
  const std::string name = (folder.has_filename() ? folder : folder.parent_path()).filename().string();
  return readRecordedFolderSettings(request.list, request.entry.empty() ? name : request.entry);
}

void writeCsv(const RecordedConsistency& judged, std::ostream& out) {
  out << "run,wheels,recording,distance,without_run_d2,without_run_nees,without_recording_d2,"
         "without_recording_nees\n";
  for (const JudgedRun& run : judged.runs)
    out << run.name << ',' << run.wheels << ',' << run.recording << ',' << run.distance << ','
        << run.without_run.d2 << ',' << run.without_run.nees << ',' << run.without_recording.d2 << ','
        << run.without_recording.nees << '\n';
}

void printRuns(const RecordedConsistency& judged) {
  std::printf(
      "\n| run | distance [m] | d2, run out | NEES | d2, recording out | NEES |\n"
      "| --- | --- | --- | --- | --- | --- |\n");
  for (const JudgedRun& run : judged.runs)
    std::printf("| %s | %.1f | %.2f | %.2f | %.2f | %.2f |\n", run.name.c_str(), run.distance,
                run.without_run.d2, run.without_run.nees, run.without_recording.d2,
                run.without_recording.nees);
}

void printShares(const char* what, const RecordedConsistency& judged, EndJudgement JudgedRun::*judgement) {
  double largest = 0.0;
  for (const JudgedRun& run : judged.runs) largest = std::max(largest, (run.*judgement).d2);
  std::printf("| %s | %.2f | %.1f %% | %.1f %% | %.1f %% |\n", what, largest,
              100.0 * shareBelow(11.83, judged.runs, judgement),
              100.0 * shareBelow(9.0, judged.runs, judgement),
              100.0 * shareBelow(1.0, judged.runs, judgement));
}

void printRepeats(const RecordedConsistency& judged) {
  std::printf(
      "\n| repeated path | runs | measured spread x, y [mm], yaw [deg] | predicted | chi-square of the "
      "position / degrees of freedom |\n| --- | --- | --- | --- | --- |\n");
  constexpr double kDegrees = 57.29577951308232;
  for (const RepeatedPath& path : judged.repeated)
    std::printf("| %s | %zu | %.1f %.1f %.2f | %.1f %.1f %.2f | %.1f / %.0f |\n", path.runs.front().c_str(),
                path.runs.size(), 1e3 * path.measured_std.x(), 1e3 * path.measured_std.y(),
                kDegrees * path.measured_std.z(), 1e3 * path.predicted_std.x(), 1e3 * path.predicted_std.y(),
                kDegrees * path.predicted_std.z(), path.chi_square, path.degrees_of_freedom);
}

void print(const RecordedConsistency& judged) {
  std::cout << noiseTable(judged.fit) << std::flush;
  printRuns(judged);
  std::printf(
      "\n| held out | largest d2 | below 11.83 | below 9 | below 1 |\n| --- | --- | --- | --- | --- |\n");
  printShares("one run", judged, &JudgedRun::without_run);
  printShares("one recording", judged, &JudgedRun::without_recording);
  printRepeats(judged);
}

}  // namespace

void recordedConsistency(int argc, const char* const* argv) {
  const Request request = parse(argc, argv);
  std::optional<calibration::AtomicFile> csv;
  if (!request.csv.empty()) csv.emplace(request.csv);
  const Parameters parameters = loadCalibratedVehicle({request.config}, request.settings);
  const std::vector<RecordedRun> runs =
      runsLongerThan(positive(request.longer_than, "longer-than"),
                     readRecordedFolder(request.folder, folderSettings(request)), parameters);
  const RecordedConsistency judged =
      judgeRecordedRuns(runs, parameters, fitSettings(request, parameters.laser_sigma));
  print(judged);
  if (!csv) return;
  std::ofstream file(csv->temporaryPath());
  writeCsv(judged, file);
  file.close();
  if (!file) throw InputError("cannot write " + request.csv);
  csv->commit();
}

}  // namespace bs_car_odometry::tools
