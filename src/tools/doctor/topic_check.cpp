#include "topic_check.hpp"

#include "bs_car_odometry/core/odometry_configuration.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace bs_car_odometry::tools::doctor {

namespace {

using Types = std::map<std::string, std::string>;

const std::string kLaserType = "geometry_msgs/PoseWithCovarianceStamped";

/// The spelling under which the bag holds a topic, if it does.
std::optional<std::string> spellingIn(const Types& types, const TopicNames& names, const std::string& name) {
  for (const std::string& spelling : names.spellings(name))
    if (types.count(spelling) > 0) return spelling;
  return std::nullopt;
}

/// True for a topic that already is one of the needed ones.
bool isTaken(const std::string& topic, const std::string& type, const std::vector<NeededTopic>& needed,
             const TopicNames& names) {
  return std::any_of(needed.begin(), needed.end(), [&](const NeededTopic& other) {
    return other.type == type && names.matches(topic, other.name);
  });
}

std::string holdings(const Types& types) {
  std::vector<std::string> list;
  for (const auto& [topic, type] : types) list.emplace_back(topic).append(" (").append(type).append(")");
  return list.empty() ? "no messages" : listed(list);
}

/// "laser_pose:=/amcl_pose", or several of them to choose from; else what the bag holds.
std::string remedy(const NeededTopic& topic, const Types& types, const std::vector<NeededTopic>& needed,
                   const TopicNames& names) {
  std::vector<std::string> remaps;
  for (const auto& [other, type] : types)
    if (type == topic.type && !isTaken(other, type, needed, names))
      remaps.push_back(topic.name + ":=" + other);
  if (remaps.size() == 1) return "give " + remaps.front();
  if (!remaps.empty()) return "give one of " + listed(remaps);
  return "record it; the bag holds " + holdings(types);
}

}  // namespace

std::vector<NeededTopic> neededTopics(const Parameters& parameters) {
  std::vector<NeededTopic> needed;
  if (parameters.input == InputSource::kJointStates) {
    needed.push_back({"joint_states", "sensor_msgs/JointState"});
  } else {
    const PerAxle<bool> steering = steeringNeeded(parameters.vehicle, parameters.odometry);
    needed.push_back({"wheel_ticks", "bs_car_odometry/WheelTicks"});
    if (steering.front) needed.push_back({"front_steering", "bs_car_odometry/SteeringAngle"});
    if (steering.rear) needed.push_back({"rear_steering", "bs_car_odometry/SteeringAngle"});
  }
  needed.push_back({"laser_pose", kLaserType});
  return needed;
}

Findings checkTopics(const Types& types, const std::vector<NeededTopic>& needed, const TopicNames& names) {
  Findings findings;
  for (const NeededTopic& topic : needed) {
    const std::optional<std::string> spelling = spellingIn(types, names, topic.name);
    if (!spelling) {
      findings.push_back(error("topic " + names.topic(topic.name) + " (" + topic.type + ") is missing",
                               remedy(topic, types, needed, names)));
    } else if (types.at(*spelling) != topic.type) {
      findings.push_back(
          error("topic " + *spelling + " is a " + types.at(*spelling) + ", not a " + topic.type,
                remedy(topic, types, needed, names)));
    }
  }
  return findings;
}

}  // namespace bs_car_odometry::tools::doctor
