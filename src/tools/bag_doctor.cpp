#include "doctor/doctor.hpp"
#include "tool.hpp"

#include <iostream>

namespace po = boost::program_options;
using namespace bs_car_odometry;

namespace {

constexpr const char* kUsage =
    "bag_doctor IN.bag --config VEHICLE.yaml [--set key=value ...] [name:=topic ...]\n"
    "Looks through a bag before it is used for a calibration: a line a finding, the worst first.\n"
    "  ERROR  a calibration from this bag would be wrong or impossible\n"
    "  WARN   it works, look at it\n"
    "  ok     in order\n"
    "Exit status: 3 with an ERROR or a bag that cannot be read, 2 when the drive does not show every gain,\n"
    "else 0, with a WARN too.";

int run(int argc, char** argv) {
  po::options_description options("Options");
  auto add = options.add_options();
  add("input", po::value<std::string>()->required(), "bag to look through");
  add("config", po::value<std::vector<std::string>>()->required()->composing(),
      "the vehicle's YAML file; further ones go on top");
  add("set", po::value<std::vector<std::string>>()->default_value({}, ""), "key=value, applied last");
  po::positional_options_description positional;
  positional.add("input", 1);
  const po::variables_map arguments = tools::parseCommandLine(argc, argv, kUsage, options, positional);
  const tools::TopicNames topics(
      argc, argv, {"wheel_ticks", "front_steering", "rear_steering", "joint_states", "laser_pose"});
  const Parameters parameters = tools::loadNominalVehicle(arguments["config"].as<std::vector<std::string>>(),
                                                          arguments["set"].as<std::vector<std::string>>());
  return tools::doctor::diagnose(arguments["input"].as<std::string>(), parameters, topics, std::cout);
}

}  // namespace

int main(int argc, char** argv) {
  int status = 0;
  const int failed = tools::runTool("bag_doctor", [&] { status = run(argc, argv); });
  return failed != 0 ? failed : status;
}
