#include "fit_noise_options.hpp"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <filesystem>
#include <map>

namespace bs_car_odometry::tools {

namespace {

namespace po = boost::program_options;
using Words = std::vector<std::string>;

std::string usage() {
  return "fit_noise IN.bag [MORE.bag ...] [--runs RUNS.yaml] --config VEHICLE.yaml --output NOISE.yaml\n"
         "          [options] [name:=topic ...]\n\n"
         "Finds the noise of the readings, the gains and how the gains differ from recording to recording\n"
         "by restricted maximum likelihood over whole drives with their truth: ground_truth, else\n"
         "laser_pose. Each bag is a recording of its own on the same wheels, unless a file says more:\n\n"
         "  summer_tyres:                       # wheels with gains of their own\n"
         "    monday: [run1.bag, run2.bag]      # one recording\n"
         "    friday: [run3.bag]\n\n"
         "Noise that can be found: " +
         listed(noiseNames()) + ".";
}

po::options_description describeOptions() {
  po::options_description options("options");
  auto add = options.add_options();
  add("input", po::value<Words>()->default_value({}, ""), "bags to read");
  add("runs", po::value<std::string>(), "YAML file of further bags, wheels -> recording -> list of bags");
  add("config", po::value<Words>()->required()->composing(),
      "the vehicle's YAML file; further ones go on top");
  add("output", po::value<std::string>()->required(), "YAML file to write: noise, gains");
  add("estimate", po::value<Words>()->default_value({}, "")->composing(),
      "a parameter of noise to find; may be repeated. Otherwise noise/wheel and, from three recordings on, "
      "noise/systematic/k_r, k_l and k_b");
  add("truth-sigma", po::value<double>(),
      "standard deviation of a true pose in x and in y [m]; otherwise laser_sigma/position");
  add("truth-yaw-sigma", po::value<double>(), "and in yaw [rad]; otherwise laser_sigma/yaw");
  add("headings", po::bool_switch(), "compare headings too: only where truth and wheels have one clock");
  add("spacing", po::value<double>()->default_value(ErrorSettings().spacing),
      "distance between the places of comparison [m]");
  add("places", po::value<int>()->default_value(ErrorSettings().most_places), "most of them in a drive");
  add("set", po::value<Words>()->default_value({}, "")->composing(), "key=value, applied last");
  return options;
}

double above0(double value, const std::string& option) {
  if (!std::isfinite(value) || value <= 0.0) throw InputError("--" + option + " must be a number above 0");
  return value;
}

double optional(const po::variables_map& values, const std::string& option, double otherwise) {
  return values.count(option) > 0 ? above0(values[option].as<double>(), option) : otherwise;
}

ErrorSettings errorSettings(const po::variables_map& values, const LaserSigma& sigma) {
  ErrorSettings settings;
  settings.truth_position = optional(values, "truth-sigma", sigma.position);
  settings.truth_yaw = optional(values, "truth-yaw-sigma", sigma.yaw);
  settings.headings = values["headings"].as<bool>();
  settings.spacing = above0(values["spacing"].as<double>(), "spacing");
  settings.most_places = values["places"].as<int>();
  if (settings.most_places < 1 || settings.most_places > 1000) throw InputError("--places must be 1 to 1000");
  return settings;
}

std::vector<NoiseBag> bagsOf(const po::variables_map& values) {
  std::vector<NoiseBag> bags;
  for (const std::string& path : values["input"].as<Words>()) bags.push_back({path, "", path});
  if (values.count("runs") > 0)
    for (const NoiseBag& bag : readRunsFile(values["runs"].as<std::string>())) bags.push_back(bag);
  if (bags.empty()) throw InputError("no bags: give them, or a file with --runs (see --help)");
  return bags;
}

}  // namespace

std::vector<NoiseBag> readRunsFile(const std::string& path) {
  using Recordings = std::map<std::string, Words>;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  std::vector<NoiseBag> bags;
  try {
    for (const auto& [wheels, recordings] : YAML::LoadFile(path).as<std::map<std::string, Recordings>>())
      for (const auto& [recording, names] : recordings)
        for (const std::string& name : names) bags.push_back({folder / name, wheels, recording});
  } catch (const YAML::BadFile&) {
    throw InputError(path + " cannot be read");
  } catch (const YAML::Exception&) {
    throw InputError(path + " is not a map of wheels to maps of recordings to lists of bags");
  }
  if (bags.empty()) throw InputError(path + " names no bags");
  return bags;
}

FitNoiseOptions fitNoiseOptions(int argc, const char* const* argv) {
  po::positional_options_description positional;
  positional.add("input", -1);
  const po::variables_map values = parseCommandLine(argc, argv, usage(), describeOptions(), positional);
  FitNoiseOptions options;
  options.topics = TopicNames(argc, argv, driveTopics());
  options.parameters = loadCalibratedVehicle(values["config"].as<Words>(), values["set"].as<Words>());
  options.settings.errors = errorSettings(values, options.parameters.laser_sigma);
  options.settings.noise = values["estimate"].as<Words>();
  options.output = values["output"].as<std::string>();
  options.bags = bagsOf(values);
  return options;
}

}  // namespace bs_car_odometry::tools
