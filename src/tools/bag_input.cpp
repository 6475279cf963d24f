#include "bag_input.hpp"

#include "bag_structure.hpp"
#include "tool.hpp"

#include "bs_car_odometry/ros/transform_reader.hpp"

#include <ros/serialization.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace bs_car_odometry::tools {

namespace {

std::string listOf(const std::map<std::string, std::string>& types) {
  std::ostringstream list;
  for (const auto& [topic, type] : types)
    list << (list.tellp() > 0 ? ", " : "") << topic << " (" << type << ")";
  return list.str();
}

bool beginsAsBag(const std::string& path) {
  constexpr const char* kBeginning = "#ROSBAG V2";
  std::string beginning(std::char_traits<char>::length(kBeginning), ' ');
  return std::ifstream(path, std::ios::binary)
             .read(beginning.data(), static_cast<std::streamsize>(beginning.size())) &&
         beginning == kBeginning;
}

}  // namespace

std::map<std::string, std::string> typesByTopic(const rosbag::Bag& bag) {
  std::map<std::string, std::string> types;
  for (const rosbag::ConnectionInfo* connection : rosbag::View(bag).getConnections())
    types[connection->topic] = connection->datatype;
  return types;
}

std::unique_ptr<rosbag::Bag> openBag(const std::string& path) {
  try {
    checkBagStructure(path);
    auto bag = std::make_unique<rosbag::Bag>();
    bag->open(path, rosbag::bagmode::Read);
    return bag;
  } catch (const rosbag::BagUnindexedException&) {
    throw InputError(path + " has no index, as when recording was cut off: repair it with 'rosbag reindex " +
                     path + "'");
  } catch (const std::runtime_error& error) {  // rosbag's own, or that of a time which is none
    if (beginsAsBag(path))
      throw InputError(path + " is cut off or damaged (" + error.what() +
                       "): what is left is kept by 'rosbag reindex " + path + "'");
    throw InputError(path + " cannot be read as a bag: " + error.what());
  }
}

void readMessages(const std::string& path, const std::function<void()>& read) {
  const auto refuse = [&path](const std::exception& error) {
    throw InputError(path + " is damaged (" + error.what() +
                     "): what comes before the damage is kept by 'rosbag reindex --force " + path + "'");
  };
  try {
    read();
  } catch (const rosbag::BagException& error) {
    refuse(error);
  } catch (const ros::serialization::StreamOverrunException& error) {
    refuse(error);
  }
}

std::optional<tf2_msgs::TFMessage> transformsOf(const rosbag::MessageInstance& message) {
  const auto bytes = message.instantiate<RawMessage<tf2_msgs::TFMessage>>();
  return bytes ? readTransforms(ByteReader(bytes->bytes)) : std::nullopt;
}

void requireTopics(const rosbag::Bag& bag, const std::string& path, const std::vector<WantedTopic>& wanted) {
  const std::map<std::string, std::string> types = typesByTopic(bag);
  if (types.empty()) throw InputError(path + " holds no messages");
  for (const WantedTopic& topic : wanted) {
    const auto spelling = std::find_if(topic.spellings.begin(), topic.spellings.end(),
                                       [&types](const std::string& name) { return types.count(name) > 0; });
    if (spelling == topic.spellings.end())
      throw InputError(path + " has no topic " + topic.spellings.front() + " (" + topic.type +
                       "); it holds " + listOf(types) + "; name another with name:=topic");
    if (types.at(*spelling) != topic.type)
      throw InputError(path + ": topic " + *spelling + " is a " + types.at(*spelling) + ", not a " +
                       topic.type);
  }
}

}  // namespace bs_car_odometry::tools
