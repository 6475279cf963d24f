#include "bag_messages.hpp"

#include <ros/serialization.h>

#include <algorithm>

namespace bs_car_odometry::tools {

namespace {

const std::string kWheelTicks{ros::message_traits::datatype<WheelTicks>()};
const std::string kSteering{ros::message_traits::datatype<SteeringAngle>()};

/// The content as a message of this type; one that is there keeps its memory.
template <typename Message>
Message& as(BagMessage& message) {
  if (auto* content = std::get_if<Message>(&message.content)) return *content;
  return message.content.emplace<Message>();
}

}  // namespace

const std::string& CallerNames::of(const rosbag::MessageInstance& message) {
  const auto header = message.getConnectionHeader();
  const auto known =
      std::find_if(names_.begin(), names_.end(), [&](const auto& name) { return name.first == header; });
  if (known != names_.end()) return known->second;
  return names_.emplace_back(header, message.getCallerId()).second;
}

MessageReader::MessageReader(rosbag::View& view, const TopicNames& names)
    : position_(view.begin()), end_(view.end()), front_steering_(names.spellings("front_steering")) {
  bytes_.reserve(1);  // so that an empty message is none at a null pointer, which roscpp would add to
}

bool MessageReader::read(BagMessage& message) {
  if (position_ == end_) return false;
  const rosbag::MessageInstance& instance = *position_;
  message.receipt = instance.getTime();
  message.publisher = callers_.of(instance);
  take(instance, message);
  ++position_;
  return true;
}

void MessageReader::take(const rosbag::MessageInstance& instance, BagMessage& message) {
  if (instance.getDataType() == kWheelTicks) {
    if (deserialize(instance, as<WheelTicks>(message))) return;
  } else if (instance.getDataType() == kSteering) {
    auto& reading = as<AxleReading>(message);
    reading.axle = axleOf(instance.getTopic());
    if (deserialize(instance, reading.message)) return;
  } else if (instance.isType<RawJointState>()) {
    deserialize(instance, as<RawJointState>(message));
    return;
  } else if (const auto pose = instance.instantiate<geometry_msgs::PoseWithCovarianceStamped>()) {
    message.content = pose;
    return;
  } else if (const auto calibration = instance.instantiate<CalibrationState>()) {
    message.content = calibration;
    return;
  }
  message.content = std::monostate();
}

/// Into a message that exists: rosbag makes each anew, and looks up its connection.
/// @return false for a message of another type
template <typename Message>
bool MessageReader::deserialize(const rosbag::MessageInstance& instance, Message& message) {
  if (!instance.isType<Message>()) return false;
  bytes_.clear();
  instance.write(*this);
  ros::serialization::IStream stream(bytes_.data(), static_cast<std::uint32_t>(bytes_.size()));
  ros::serialization::deserialize(stream, message);
  return true;
}

Axle MessageReader::axleOf(const std::string& topic) const {
  const bool front =
      std::find(front_steering_.begin(), front_steering_.end(), topic) != front_steering_.end();
  return front ? Axle::kFront : Axle::kRear;
}

}  // namespace bs_car_odometry::tools
