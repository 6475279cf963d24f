#include "calibrate_options.hpp"

#include <cmath>
#include <filesystem>
#include <system_error>

namespace bs_car_odometry::tools {

namespace {

namespace po = boost::program_options;
using Words = std::vector<std::string>;

constexpr const char* kUsage =
    "calibrate_bag IN.bag [MORE.bag ...] --config VEHICLE.yaml --output CAL.yaml [options] [name:=topic "
    "...]\n\n"
    "The calibration over one or several drives, through the code of the node: wheels, steering and\n"
    "laser_pose in, a file of gains out, for replay_bag --calibration or the parameter calibration_file.\n"
    "Gains go on from bag to bag, each drive has a beginning of its own. Without --no-refine the noise is\n"
    "estimated too, and everything is fitted once more at once; that result is the one written. By default\n"
    "it is the most likely one. --objective path makes dead reckoning from the first laser pose of each bag\n"
    "end near the laser, whatever it is that makes the car drift; it needs longer drives.\n\n"
    "Exit status: 0 good; 2 a gain was not observed, nothing is written, and what to drive is said;\n"
    "3 bad input, or a gain outside 0.8 to 1.2; 4 the fit did not converge.";

po::options_description describeOptions() {
  po::options_description options("options");
  auto add = options.add_options();
  add("input", po::value<Words>()->required(), "bags to read");
  add("config", po::value<Words>()->required()->composing(),
      "the vehicle's YAML file; further ones go on top");
  add("output", po::value<std::string>()->required(), "calibration file to write");
  add("report", po::value<std::string>(), "folder to write figures, tables and a page index.html to");
  add("pdf", po::bool_switch(), "with --report: the figures as report.pdf too");
  add("no-refine", po::bool_switch(), "the filter alone, as calibration_node");
  add("objective", po::value<std::string>()->default_value("likelihood"),
      "of the fit: likelihood, for the best gains where the noise model holds, or path, for the least drift");
  add("distance", po::value<double>(),
      "length of the first bag's straight drive by tape [m], with calibration/method=paper");
  add("set", po::value<Words>()->default_value({}, "")->composing(), "key=value, applied last");
  return options;
}

/// The calibration must not take the place of a recording.
void requireDifferent(const CalibrateOptions& options) {
  for (const std::string& bag : options.bags) {
    std::error_code unreadable;
    if (bag == options.output || std::filesystem::equivalent(bag, options.output, unreadable))
      throw InputError("--output must not be one of the bags");
  }
}

calibration::Objective objectiveOf(const po::variables_map& values) {
  const auto& word = values["objective"].as<std::string>();
  if (word == "likelihood") return calibration::Objective::kLikelihood;
  if (word != "path") throw InputError("--objective must be likelihood or path, not '" + word + "'");
  if (values["no-refine"].as<bool>())
    throw InputError("--objective is that of the fit, which --no-refine leaves out");
  return calibration::Objective::kPath;
}

std::optional<double> tapeDistance(const po::variables_map& values, const Parameters& parameters) {
  if (values.count("distance") == 0) return std::nullopt;
  const double distance = values["distance"].as<double>();
  if (!std::isfinite(distance) || distance <= 0.0)
    throw InputError("--distance must be a number of metres above 0");
  if (parameters.calibration.method != CalibrationMethod::kPaper)
    throw InputError("--distance is for the paper's stage 1: give --set calibration/method=paper too");
  return distance;
}

}  // namespace

CalibrateOptions calibrateOptions(int argc, const char* const* argv) {
  po::positional_options_description positional;
  positional.add("input", -1);
  const po::variables_map values = parseCommandLine(argc, argv, kUsage, describeOptions(), positional);
  CalibrateOptions options;
  options.topics = TopicNames(
      argc, argv,
      {"wheel_ticks", "front_steering", "rear_steering", "joint_states", "laser_pose", "tf", "tf_static"});
  options.parameters = loadNominalVehicle(values["config"].as<Words>(), values["set"].as<Words>());
  options.bags = values["input"].as<Words>();
  options.output = values["output"].as<std::string>();
  if (values.count("report") > 0) options.report = values["report"].as<std::string>();
  options.pdf = values["pdf"].as<bool>();
  options.refine = !values["no-refine"].as<bool>();
  options.objective = objectiveOf(values);
  options.distance = tapeDistance(values, options.parameters);
  if (options.pdf && options.report.empty()) throw InputError("--pdf needs --report");
  requireDifferent(options);
  return options;
}

}  // namespace bs_car_odometry::tools
