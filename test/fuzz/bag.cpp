// Any bytes as a bag, through what the tools read one with: refused with a sentence, or odometry of it.

#include "bag_input.hpp"
#include "bag_messages.hpp"
#include "bytes.hpp"
#include "memory_file.hpp"

#include "bs_car_odometry/ros/laser_input.hpp"
#include "bs_car_odometry/ros/odometry_adapter.hpp"

#include <console_bridge/console.h>
#include <sanitizer/lsan_interface.h>

namespace bs_car_odometry::fuzz {
namespace {

Parameters parameters(InputSource input) {
  Parameters parameters;
  parameters.input = input;
  parameters.joints.wheels = {{"fl", "fr", "rl", "rr"}};
  parameters.joints.steering = {{"s"}, {}};
  parameters.vehicle.wheelbase = 1.2;
  parameters.vehicle.track = {1.2, 1.2};
  parameters.vehicle.metres_per_tick.values.fill(1e-4);
  parameters.relative_motion.history = Duration::zero();
  return parameters;
}

void give(const tools::BagMessage& message, OdometryAdapter& adapter) {
  using geometry_msgs::PoseWithCovarianceStampedConstPtr;
  if (tools::giveInput(message, adapter)) return;
  if (const auto* pose = std::get_if<PoseWithCovarianceStampedConstPtr>(&message.content))
    adapter.setPose(**pose);
  else if (const auto* calibration = std::get_if<CalibrationStateConstPtr>(&message.content))
    adapter.add(**calibration);
}

/// With one adapter for all runs, which forgets the last one: to make one takes longer than to read a small
/// bag.
template <InputSource kInput>
void readOdometry(const rosbag::Bag& bag) {
  static OdometryAdapter adapter(parameters(kInput));
  adapter.clockWentBack(true);
  rosbag::View view(bag);
  tools::MessageReader reader(view, tools::TopicNames());
  tools::BagMessage message;
  while (reader.read(message)) {
    give(message, adapter);
    while (const auto update = adapter.next(message.receipt))
      require(update->estimate.pose.isFinite(), "the pose is finite");
  }
}

void readMount(const rosbag::Bag& bag) {
  LaserMountFinder finder("base_link", "laser");
  for (const rosbag::MessageInstance& message : rosbag::View(bag))
    if (const auto transforms = tools::transformsOf(message)) finder.add(*transforms);
  require(!finder.mount() || finder.mount()->isFinite(), "the mount is finite");
}

void read(const std::string& path) {
  const std::unique_ptr<rosbag::Bag> bag = tools::openBag(path);
  tools::requireTopics(*bag, path, {});
  tools::readMessages(path, [&] {
    readOdometry<InputSource::kWheelTicks>(*bag);
    readOdometry<InputSource::kJointStates>(*bag);
    readMount(*bag);
  });
}

/// Not after each run, as libFuzzer does when a run keeps memory: rosbag's loader of plugins always does.
void checkForLeaks() {
  constexpr std::size_t kEvery = 1000;
  static std::size_t runs = 0;
  if (++runs % kEvery == 0) require(__lsan_do_recoverable_leak_check() == 0, "nothing leaks");
}

}  // namespace
}  // namespace bs_car_odometry::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace bs_car_odometry;
  static fuzz::MemoryFile file;
  static const rosbag::Bag kept;  // keeps rosbag's plugins loaded: each run would load them anew
  console_bridge::noOutputHandler();
  file.write(fuzz::textOf(data, size));
  try {
    fuzz::read(file.path());
  } catch (const tools::InputError& error) {
    fuzz::require(*error.what() != '\0', "it says why");
  }
  fuzz::checkForLeaks();
  return 0;
}
