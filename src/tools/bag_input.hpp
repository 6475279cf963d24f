#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// Opens a bag for reading.
/// @throws InputError naming what is wrong and the command that repairs it
std::unique_ptr<rosbag::Bag> openBag(const std::string& path);

/// Calls `read`, which goes through the messages of a bag.
/// @throws InputError with the command that repairs the bag when a message cannot be read
void readMessages(const std::string& path, const std::function<void()>& read);

/// The transforms of a message of tf; none for another message, or when a length does not fit the bytes.
std::optional<tf2_msgs::TFMessage> transformsOf(const rosbag::MessageInstance& message);

/// Every topic of a bag with its type.
std::map<std::string, std::string> typesByTopic(const rosbag::Bag& bag);

/// A topic that a tool reads, under any of its spellings, and the type that it must have.
struct WantedTopic {
  std::vector<std::string> spellings;
  std::string type;
};

/// Checks that every wanted topic is in the bag, with its type.
/// @throws InputError listing what is missing and what the bag holds instead
void requireTopics(const rosbag::Bag& bag, const std::string& path, const std::vector<WantedTopic>& wanted);

}  // namespace bs_car_odometry::tools
