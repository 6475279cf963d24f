#include "input_topics.hpp"

#include "bs_car_odometry/core/odometry_configuration.hpp"
#include "bs_car_odometry/ros/verdicts.hpp"

#include <sstream>

namespace bs_car_odometry::tools {

InputTopics::InputTopics(const Parameters& parameters, const TopicNames& names) : names_(names) {
  if (parameters.input == InputSource::kJointStates) {
    require("joint_states", "sensor_msgs/JointState");
    return;
  }
  const PerAxle<bool> steering_needed = steeringNeeded(parameters.vehicle, parameters.odometry);
  require("wheel_ticks", "bs_car_odometry/WheelTicks");
  if (steering_needed.front) require("front_steering", "bs_car_odometry/SteeringAngle");
  if (steering_needed.rear) require("rear_steering", "bs_car_odometry/SteeringAngle");
}

void InputTopics::require(const std::string& name, const std::string& type) {
  required_.push_back({names_.spellings(name), type});
}

std::vector<std::string> InputTopics::spellings() const {
  std::vector<std::string> spellings;
  for (const WantedTopic& topic : required_)
    spellings.insert(spellings.end(), topic.spellings.begin(), topic.spellings.end());
  return spellings;
}

std::string reasons(const InputCounts& counts) {
  std::ostringstream text;
  for (std::size_t i = 0; i < counts.verdicts.size(); ++i)
    if (counts.verdicts[i] > 0)
      text << "; " << counts.verdicts[i] << " messages dropped: " << explain(static_cast<Verdict>(i));
  return text.str();
}

}  // namespace bs_car_odometry::tools
