#include "simulated_drive_bag.hpp"

#include "bag_writer.hpp"
#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/simulated_drive.hpp"
#include "tool.hpp"

#include <iostream>
#include <string>
#include <vector>

namespace bs_car_odometry::tools {

namespace {

namespace po = boost::program_options;

constexpr double kLatestStart = 4.2e9;  // s: stamps hold 32 bits of seconds

struct Request {
  SimulatedDriveSettings drive;
  std::string config;
  std::string output;
  std::vector<std::string> settings;
  double start{0.0};
  bool no_truth{false};
};

po::options_description optionsFor(Request& request) {
  SimulatedDriveSettings& drive = request.drive;
  po::options_description options("options");
  auto add = options.add_options();
  add("scenario", po::value(&drive.scenario)->required(), "what the car drives, see above");
  add("config", po::value(&request.config)->required(), "vehicle file");
  add("output", po::value(&request.output)->required(), "bag to write");
  add("seed", po::value(&drive.seed)->default_value(drive.seed),
      "of the noise: the same seed is the same drive");
  add("rate", po::value(&drive.rate)->default_value(drive.rate), "wheel messages [Hz]");
  add("steering-rate", po::value(&drive.steering_rate),
      "steering messages [Hz]; one with each wheel message");
  add("laser-rate", po::value(&drive.laser_rate)->default_value(drive.laser_rate),
      "laser poses [Hz], 0: none");
  add("noise-free", po::bool_switch(&drive.noise_free), "true gains as configured, no noise");
  add("draw-gains", po::bool_switch(&drive.draw_gains), "true parameters drawn from noise/systematic");
  add("duration", po::value(&drive.duration), "of the drive [s]; the scenario repeats in a longer one");
  add("speed-factor", po::value(&drive.speed_factor)->default_value(1.0), "multiplies the scenario's speed");
  add("start-time", po::value(&request.start)->default_value(1.6e9, "1600000000"), "stamp of the start [s]");
  add("no-truth", po::bool_switch(&request.no_truth), "without ground_truth");
  add("set", po::value(&request.settings)->composing(), "parameter=value, instead of the vehicle file's");
  return options;
}

Request parse(int argc, const char* const* argv) {
  Request request;
  const std::string usage =
      "simulate --scenario NAME --config VEHICLE.yaml --output OUT.bag [options] [name:=topic ...]\n\n"
      "A recorded drive of a simulated car, with noise and with true gains (k_r, k_l, k_b) that are\n"
      "(1.02, 0.99, 1.03) times the configured ones; it prints what is true. Topics: wheel_ticks,\n"
      "front_steering, rear_steering (where measured), laser_pose, ground_truth.\n\nscenarios:\n" +
      simulation::scenarioDescriptions();
  parseCommandLine(argc, argv, usage, optionsFor(request));
  request.drive.truth = !request.no_truth;
  if (!(request.start >= 1.0 && request.start + request.drive.duration <= kLatestStart))
    throw InputError("the drive must start at 1 s or later and end before 4.2e9 s");
  return request;
}

/// @return the number of messages
std::size_t writeBag(SimulatedDrive& drive, Time start, const TopicNames& topics, const std::string& path) {
  BagWriter bag(path);
  Progress progress("simulate", drive.duration());
  std::size_t messages = 0;
  while (const std::optional<SimulatedMessage> message = drive.next()) {
    const ros::Time receipt = toRos(message->receipt);
    const std::string topic = topics.topic(message->topic);
    std::visit([&](const auto& content) { bag.write(topic, receipt, content); }, message->content);
    progress.update(toSeconds(message->receipt - start));
    ++messages;
  }
  bag.commit();
  return messages;
}

}  // namespace

void simulate(int argc, const char* const* argv) {
  const Request request = parse(argc, argv);
  const TopicNames topics(
      argc, argv,
      {"wheel_ticks", "front_steering", "rear_steering", "laser_pose", "ground_truth", "tf_static"});
  const Parameters parameters = loadCalibratedVehicle({request.config}, request.settings);
  if (parameters.input == InputSource::kJointStates)
    throw InputError(
        "the bag will hold wheel_ticks, not joint_states: give a vehicle with 'input: wheel_ticks'");
  const Time start = Time(durationFromSeconds(request.start));
  SimulatedDrive drive(parameters, request.drive, start);
  const std::size_t messages = writeBag(drive, start, topics, request.output);
  std::cout << "# " << request.output << ": " << messages << " messages, " << drive.duration() << " s of "
            << request.drive.scenario << "; the car's true parameters are\n"
            << describe(drive.truth());
}

}  // namespace bs_car_odometry::tools
