#include "bad_bags.hpp"

#include "damaged_drive.hpp"

#include "bs_car_odometry/WheelTicks.h"

#include <rosbag/bag.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace bs_car_odometry::tools::testing {

namespace {

std::string bytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void write(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

void record(const std::string& path, const Damage& damage) {
  SimulatedDriveSettings settings;
  settings.scenario = "fig4";
  recordDrive(path, cycab(), settings, damage);
}

/// A bag that was being written when the process was killed: rosbag has not come to its index.
std::string unindexed(const std::string& good) {
  std::string bytes = good;
  // The field of the first record: index_pos, 8 bytes, which rosbag fills in last.
  const std::size_t field = bytes.find("index_pos=") + std::string("index_pos=").size();
  bytes.replace(field, 8, std::string(8, '\0'));
  return bytes;
}

/// Compressed messages that are not what was written.
std::string corrupted(const std::string& good) {
  std::string bytes = good;
  const std::size_t from = bytes.size() / 4;
  for (std::size_t i = from; i < from + 2000; ++i) bytes[i] = static_cast<char>(0xff);
  return bytes;
}

bool isWheels(const SimulatedMessage& message) { return message.topic == "wheel_ticks"; }

bool renameWheels(SimulatedMessage& message) {
  if (isWheels(message)) message.topic = "wheels";
  return true;
}

/// Steering angles in the place of the wheels.
bool swapType(SimulatedMessage& message) {
  if (isWheels(message)) return false;
  if (message.topic == "front_steering") message.topic = "wheel_ticks";
  return true;
}

}  // namespace

std::vector<BadBag> writeBadBags(const std::string& folder) {
  const auto path = [&folder](const std::string& name) { return folder + "/" + name + ".bag"; };
  record(path("good"), {});
  const std::string good = bytesOf(path("good"));
  write(path("no_bytes"), "");
  write(path("text"), "t,fl,fr\n0,1,2\n");
  write(path("unindexed"), unindexed(good));
  write(path("cut"), good.substr(0, good.size() / 2));
  write(path("corrupted"), corrupted(good));
  { const rosbag::Bag empty(path("no_messages"), rosbag::bagmode::Write); }
  record(path("topic_absent"), renameWheels);
  record(path("wrong_type"), swapType);
  const std::string reindex = "rosbag reindex";
  return {{"no_bytes", path("no_bytes"), {"cannot be read as a bag"}},
          {"text", path("text"), {"cannot be read as a bag"}},
          {"unindexed", path("unindexed"), {"has no index", reindex}},
          {"cut", path("cut"), {"cut off", reindex}},
          {"corrupted", path("corrupted"), {"damaged", reindex}},
          {"no_messages", path("no_messages"), {"holds no messages"}},
          {"topic_absent", path("topic_absent"), {"/wheel_ticks", "/wheels", ":="}},
          {"wrong_type", path("wrong_type"), {"/wheel_ticks is a bs_car_odometry/SteeringAngle, not a"}}};
}

}  // namespace bs_car_odometry::tools::testing
