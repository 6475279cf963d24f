#include "replay.hpp"
#include "tool.hpp"

namespace po = boost::program_options;
using namespace bs_car_odometry;

namespace {

constexpr const char* kUsage =
    "replay_bag IN.bag --config VEHICLE.yaml --output OUT.bag [--calibration CAL.yaml] [--tum FILE] "
    "[--set key=value ...] "
    "[name:=topic ...]\n"
    "The odometry over a recorded bag, through the code of the nodelet; bit for bit the same on every run.";

void run(int argc, char** argv) {
  po::options_description options("Options");
  auto add = options.add_options();
  add("input", po::value<std::string>()->required(), "bag to read");
  add("config", po::value<std::vector<std::string>>()->required()->composing(),
      "the vehicle's YAML file; further ones go on top");
  add("calibration", po::value<std::string>(), "calibration file, on top of the vehicle's: calibration_file");
  add("output", po::value<std::string>(), "bag to write: odom, odometry_status, /tf");
  add("tum", po::value<std::string>(), "trajectory to write: t x y z qx qy qz qw per line");
  add("set", po::value<std::vector<std::string>>()->default_value({}, ""), "key=value, applied last");
  po::positional_options_description positional;
  positional.add("input", 1);
  const po::variables_map arguments = tools::parseCommandLine(argc, argv, kUsage, options, positional);
  const tools::TopicNames topics(
      argc, argv,
      {"wheel_ticks", "front_steering", "rear_steering", "joint_states", "set_pose", "calibration"});

  auto settings = arguments["set"].as<std::vector<std::string>>();
  const auto optional = [&arguments](const char* name) {
    return arguments.count(name) > 0 ? arguments[name].as<std::string>() : std::string();
  };
  if (arguments.count("calibration") > 0) settings.push_back("calibration_file=" + optional("calibration"));
  const tools::ReplayFiles files{arguments["input"].as<std::string>(), optional("output"), optional("tum")};
  if (files.output.empty() && files.tum.empty())
    throw tools::InputError("nothing to write: give --output or --tum");
  const auto configs = arguments["config"].as<std::vector<std::string>>();
  tools::replay(tools::loadCalibratedVehicle(configs, settings), topics, files);
}

}  // namespace

int main(int argc, char** argv) {
  return tools::runTool("replay_bag", [&] { run(argc, argv); });
}
