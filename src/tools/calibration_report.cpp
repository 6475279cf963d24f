#include "calibration_report.hpp"

#include "program.hpp"

#include "bs_car_odometry/calibration/drive_bound.hpp"
#include "bs_car_odometry/parameters/load.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace bs_car_odometry::tools {

using namespace calibration;

namespace {

std::string inFolder(const std::string& folder, const std::string& name) {
  return (std::filesystem::path(folder) / name).string();
}

std::string madeFolder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    throw InputError("--report " + folder + ": cannot make that folder" +
                     (error ? ": " + error.message() : std::string()));
  return folder;
}

std::vector<std::string> updateColumns() {
  std::vector<std::string> columns{"stamp",
                                   "distance",
                                   "x",
                                   "y",
                                   "yaw",
                                   "laser_x",
                                   "laser_y",
                                   "laser_yaw",
                                   "innovation_x",
                                   "innovation_y",
                                   "innovation_yaw",
                                   "nis",
                                   "weight",
                                   "stage",
                                   "k_d_front",
                                   "k_d_front_std",
                                   "k_d_rear",
                                   "k_d_rear_std"};
  for (std::size_t i = 0; i < kCount; ++i) {
    columns.push_back(parameterName(i));
    columns.push_back(parameterName(i) + "_std");
  }
  for (const char* name : {"innovation_x_std", "innovation_y_std", "innovation_yaw_std"})
    columns.emplace_back(name);
  return columns;
}

std::vector<std::size_t> estimatedOnes(const Findings& findings) {
  std::vector<std::size_t> estimated;
  for (std::size_t i = 0; i < kCount; ++i)
    if (findings.estimated()[i]) estimated.push_back(i);
  return estimated;
}

/// DIR/paths.csv: a row for each laser pose that was not rejected.
void writePaths(const std::string& folder, const Findings& findings) {
  CsvWriter csv(inFolder(folder, "paths.csv"),
                {"bag", "stamp", "distance", "laser_x", "laser_y", "laser_yaw", "before_x", "before_y",
                 "before_yaw", "after_x", "after_y", "after_yaw"});
  for (std::size_t bag = 0; bag < findings.paths.size(); ++bag) {
    const auto& lasers = findings.filtered.bags[bag].drive.lasers();
    for (std::size_t i = 0; i < findings.paths[bag].after.size(); ++i) {
      const ReckonedPose& before = findings.paths[bag].before[i];
      const ReckonedPose& after = findings.paths[bag].after[i];
      csv.add(static_cast<double>(bag)).add(lasers[after.laser].laser.stamp).add(after.distance);
      csv.add(after.measured).add(before.reckoned).add(after.reckoned).endRow();
    }
  }
  csv.commit();
}

/// DIR/bound.csv: the bound along all drives, linearised at the values that were found.
class BoundTable {
 public:
  BoundTable(const std::string& folder, const Findings& findings)
      : findings_(findings),
        estimated_(estimatedOnes(findings)),
        csv_(inFolder(folder, "bound.csv"), columns()),
        model_(findings.filtered.parameters),
        bound_(atEstimate(findings), findings.estimated(), findings.filtered.prior) {
    model_.setValues(findings.values);
    if (!findings.noise || !findings.noise->converged) return;
    const LaserScales scales = findings.noise->laserScales();
    scale_ = {scales.position, scales.position, scales.yaw};
  }

  void write() {
    for (std::size_t i = 0; i < findings_.filtered.bags.size(); ++i) {
      if (i > 0) bound_.newDrive();
      write(findings_.filtered.bags[i]);
    }
    csv_.commit();
  }

 private:
  /// With the noise that was found.
  static Parameters atEstimate(const Findings& findings) {
    Parameters parameters = findings.filtered.parameters;
    if (findings.noise && findings.noise->converged) parameters = withNoise(*findings.noise, parameters);
    setValues(findings.values, parameters);
    return parameters;
  }

  std::vector<std::string> columns() const {
    std::vector<std::string> columns{"stamp", "distance", "k_d_front", "k_d_rear"};
    for (const std::size_t i : estimated_) columns.push_back(parameterName(i));
    return columns;
  }

  void write(const CalibratedBag& bag) {
    const Duration late = durationFromSeconds(findings_.values[kTimeOffset]);
    DriveWalk walk(bag.drive);
    for (std::size_t i = 0; i < bag.drive.lasers().size(); ++i) {
      const DriveLaser& laser = bag.drive.lasers()[i];
      const bool seen = walk.moveTo(laser.laser.stamp - late, [this](const MeasuredStep& step) {
        bound_.move({step.span, model_.adapted(step.readings), step.steering_doubt});
      });
      if (i > 0 && (!seen || laser.jumped)) bound_.newDrive();
      if (!bag.good[i]) continue;
      bound_.update(scale_.asDiagonal() * laser.laser.covariance * scale_.asDiagonal());
      writeRow(laser.laser.stamp, bag.distances[i]);
    }
  }

  void writeRow(Time stamp, double distance) {
    FilterEstimate bound;
    bound.values = findings_.values;
    bound.covariance = bound_.covariance();
    setDistanceGains(findings_.filtered.parameters.vehicle, bound);
    csv_.add(stamp).add(distance);
    for (const Axle axle : kAllAxles) csv_.add(std::sqrt(bound.k_d_variance[axle]));
    for (const std::size_t i : estimated_)
      csv_.add(std::sqrt(bound.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i))));
    csv_.endRow();
  }

  const Findings& findings_;
  std::vector<std::size_t> estimated_;
  CsvWriter csv_;
  MotionModel model_;
  DriveBound bound_;
  Eigen::Vector3d scale_{Eigen::Vector3d::Ones()};  ///< of the laser's deviations
};

/// Strings of YAML in double quotes are JSON, but for control characters.
std::string plain(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 && c != '\n') c = ' ';
  return text;
}

void emit(YAML::Emitter& json, const Drift& drift) {
  json << YAML::BeginMap << YAML::Key << "error" << YAML::Value << drift.error << YAML::Key << "percent"
       << YAML::Value << drift.percent() << YAML::EndMap;
}

void emitBags(YAML::Emitter& json, const Findings& findings) {
  json << YAML::BeginSeq;
  for (std::size_t i = 0; i < findings.paths.size(); ++i) {
    const CalibratedBag& bag = findings.filtered.bags[i];
    const BagPaths& paths = findings.paths[i];
    json << YAML::BeginMap;
    json << YAML::Key << "name" << YAML::Value << plain(bag.name());
    json << YAML::Key << "distance" << YAML::Value << bag.distance;
    json << YAML::Key << "laser_poses" << YAML::Value << bag.good.size();
    json << YAML::Key << "rejected" << YAML::Value << std::count(bag.good.begin(), bag.good.end(), false);
    json << YAML::Key << "drift_before" << YAML::Value;
    emit(json, driftOf(paths.before));
    json << YAML::Key << "drift_after" << YAML::Value;
    emit(json, driftOf(paths.after));
    if (!findings.left_out.empty()) {
      json << YAML::Key << "drift_left_out" << YAML::Value;
      emit(json, findings.left_out[i].calibrated);
    }
    json << YAML::EndMap;
  }
  json << YAML::EndSeq;
}

void emitParameters(YAML::Emitter& json, const Findings& findings) {
  const FilteredBags& filtered = findings.filtered;
  const ParameterVector configured = valuesOf(filtered.parameters);
  json << YAML::BeginSeq;
  for (const std::size_t i : estimatedOnes(findings)) {
    const auto k = static_cast<Eigen::Index>(i);
    json << YAML::BeginMap;
    json << YAML::Key << "name" << YAML::Value << parameterName(i);
    json << YAML::Key << "configured" << YAML::Value << configured[k];
    json << YAML::Key << "value" << YAML::Value << findings.values[k];
    json << YAML::Key << "deviation" << YAML::Value << findings.deviation(i);
    json << YAML::Key << "filter_value" << YAML::Value << filtered.estimate.values[k];
    json << YAML::Key << "filter_deviation" << YAML::Value << std::sqrt(filtered.estimate.covariance(k, k));
    json << YAML::Key << "prior" << YAML::Value << filtered.prior[k];
    json << YAML::Key << "observed" << YAML::Value << static_cast<bool>(findings.observed[i]);
    json << YAML::EndMap;
  }
  json << YAML::EndSeq;
}

void emitCovariance(YAML::Emitter& json, const Findings& findings) {
  const std::vector<std::size_t> estimated = estimatedOnes(findings);
  json << YAML::BeginSeq;
  for (const std::size_t i : estimated) {
    json << YAML::BeginSeq;
    for (const std::size_t j : estimated)
      json << findings.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    json << YAML::EndSeq;
  }
  json << YAML::EndSeq;
}

void emit(YAML::Emitter& json, const char* name, const NoiseLevel& level) {
  json << YAML::BeginMap;
  json << YAML::Key << "name" << YAML::Value << name;
  json << YAML::Key << "configured" << YAML::Value << level.configured;
  json << YAML::Key << "value" << YAML::Value << level.value;
  json << YAML::Key << "deviation" << YAML::Value << level.deviation;
  json << YAML::Key << "found" << YAML::Value << level.found;
  json << YAML::EndMap;
}

void emitNoise(YAML::Emitter& json, const Findings& findings) {
  json << YAML::BeginSeq;
  if (findings.noise) {
    emit(json, "wheel [m/sqrt(m)]", findings.noise->wheel);
    emit(json, "laser, position [m]", findings.noise->laser_position);
    emit(json, "laser, yaw [rad]", findings.noise->laser_yaw);
  }
  json << YAML::EndSeq;
}

void writeSummary(const std::string& folder, const Findings& findings, const CalibrationSummary& summary) {
  const Parameters& parameters = findings.filtered.parameters;
  YAML::Emitter json;
  json.SetMapFormat(YAML::Flow);
  json.SetSeqFormat(YAML::Flow);
  json.SetStringFormat(YAML::DoubleQuoted);
  json.SetDoublePrecision(12);
  json << YAML::BeginMap;
  json << YAML::Key << "vehicle" << YAML::Value << plain(parameters.vehicle.name);
  json << YAML::Key << "method" << YAML::Value << parameterWord(parameters, "calibration/method");
  json << YAML::Key << "axles" << YAML::Value << parameterWord(parameters, "odometry/axles");
  json << YAML::Key << "good" << YAML::Value << summary.good;
  json << YAML::Key << "verdict" << YAML::Value << plain(summary.verdict);
  json << YAML::Key << "mean_nis" << YAML::Value << findings.filtered.mean_nis;
  json << YAML::Key << "bags" << YAML::Value;
  emitBags(json, findings);
  json << YAML::Key << "parameters" << YAML::Value;
  emitParameters(json, findings);
  json << YAML::Key << "covariance" << YAML::Value;
  emitCovariance(json, findings);
  json << YAML::Key << "noise" << YAML::Value;
  emitNoise(json, findings);
  json << YAML::Key << "calibration_file" << YAML::Value << plain(summary.file);
  json << YAML::EndMap;
  AtomicFile output(inFolder(folder, "summary.json"));
  std::ofstream(output.temporaryPath()) << json.c_str() << '\n';
  output.commit();
}

void plot(const std::string& folder, bool pdf) {
  std::vector<std::string> command{besideThisProgram("plot_calibration"), folder};
  if (pdf) command.emplace_back("--pdf");
  try {
    runProgram(command);
  } catch (const InputError& error) {
    warn(std::string(error.what()) + ": no figures; the tables are in " + folder);
  }
}

}  // namespace

CsvWriter::CsvWriter(const std::string& path, const std::vector<std::string>& columns)
    : output_(path), file_(std::fopen(output_.temporaryPath().c_str(), "w")) {
  if (!file_) throw InputError("cannot write " + path + ": " + std::strerror(errno));
  for (std::size_t i = 0; i < columns.size(); ++i)
    std::fprintf(file_.get(), "%s%s", i > 0 ? "," : "", columns[i].c_str());
  std::fputc('\n', file_.get());
}

void CsvWriter::separate() {
  if (row_begun_) std::fputc(',', file_.get());
  row_begun_ = true;
}

CsvWriter& CsvWriter::add(double value) {
  separate();
  std::fprintf(file_.get(), "%.10g", value);
  return *this;
}

CsvWriter& CsvWriter::add(Time stamp) {
  separate();
  const auto nanoseconds = static_cast<long long>(stamp.time_since_epoch().count());
  std::fprintf(file_.get(), "%lld.%09lld", nanoseconds / 1000000000, nanoseconds % 1000000000);
  return *this;
}

CsvWriter& CsvWriter::add(const Pose2& pose) { return add(pose.x).add(pose.y).add(pose.yaw); }

void CsvWriter::endRow() {
  std::fputc('\n', file_.get());
  row_begun_ = false;
}

void CsvWriter::commit() {
  const bool written = std::ferror(file_.get()) == 0 && std::fflush(file_.get()) == 0;
  file_.reset();
  if (!written) throw InputError("cannot write the report: " + std::string(std::strerror(errno)));
  output_.commit();
}

UpdatesTable::UpdatesTable(const std::string& folder)
    : csv_(inFolder(madeFolder(folder), "updates.csv"), updateColumns()) {}

void UpdatesTable::add(const CalibrationUpdate& update) {
  const FilterEstimate& estimate = update.estimate;
  const Innovation& innovation = update.innovation;
  csv_.add(update.stamp).add(update.distance).add(estimate.pose).add(update.laser.pose);
  for (const double residual : {innovation.residual.x(), innovation.residual.y(), innovation.residual.z()})
    csv_.add(residual);
  csv_.add(innovation.nis).add(innovation.weight).add(static_cast<double>(estimate.stage));
  for (const Axle axle : kAllAxles) csv_.add(estimate.k_d[axle]).add(std::sqrt(estimate.k_d_variance[axle]));
  for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(kCount); ++k)
    csv_.add(estimate.values[k]).add(std::sqrt(estimate.covariance(k, k)));
  for (Eigen::Index k = 0; k < 3; ++k) csv_.add(std::sqrt(innovation.covariance(k, k)));
  csv_.endRow();
}

void writeReport(const std::string& folder, bool pdf, const Findings& findings,
                 const CalibrationSummary& summary) {
  writePaths(folder, findings);
  BoundTable(folder, findings).write();
  writeSummary(folder, findings, summary);
  plot(folder, pdf);
}

}  // namespace bs_car_odometry::tools
