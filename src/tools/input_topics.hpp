#pragma once

#include "bag_input.hpp"
#include "tool.hpp"

#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"
#include "bs_car_odometry/ros/odometry_adapter.hpp"

#include <ros/serialization.h>
#include <rosbag/view.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace bs_car_odometry::tools {

/// The topics that the odometry reads with these parameters.
class InputTopics {
 public:
  InputTopics(const Parameters& parameters, const TopicNames& names);

  /// One topic more.
  void require(const std::string& name, const std::string& type);

  const std::vector<WantedTopic>& required() const { return required_; }

  /// Of all that is required.
  std::vector<std::string> spellings() const;

 private:
  const TopicNames& names_;
  std::vector<WantedTopic> required_;
};

/// Takes messages out of a bag into ones that exist: rosbag makes each anew, and looks up its connection.
class MessageReader {
 public:
  /// @return false for a message of another type
  template <typename Message>
  bool read(const rosbag::MessageInstance& instance, Message& message) {
    if (!instance.isType<Message>()) return false;
    bytes_.clear();
    instance.write(*this);
    ros::serialization::IStream stream(bytes_.data(), static_cast<std::uint32_t>(bytes_.size()));
    ros::serialization::deserialize(stream, message);
    return true;
  }

  /// Room for the bytes of a message, for rosbag.
  std::uint8_t* advance(std::uint32_t size) {
    bytes_.resize(size);
    return bytes_.data();
  }

 private:
  std::vector<std::uint8_t> bytes_;
};

/// Names of the nodes that published a bag's messages, looked up once for each connection.
class CallerNames {
 public:
  const std::string& of(const rosbag::MessageInstance& message) {
    const Header header = message.getConnectionHeader();
    const auto known =
        std::find_if(names_.begin(), names_.end(), [&](const auto& name) { return name.first == header; });
    if (known != names_.end()) return known->second;
    return names_.emplace_back(header, message.getCallerId()).second;
  }

 private:
  using Header = boost::shared_ptr<ros::M_string>;
  std::vector<std::pair<Header, std::string>> names_;
};

/// Gives recorded wheels and angles to an OdometryAdapter or a CalibrationAdapter.
class InputFeed {
 public:
  explicit InputFeed(const TopicNames& names) : front_steering_(names.spellings("front_steering")) {}

  /// @return false for a message that is none of the odometry's inputs
  template <typename Adapter>
  bool feed(const rosbag::MessageInstance& message, Adapter& adapter) {
    const ros::Time& receipt = message.getTime();
    const Sender sender{callers_.of(message), toTime(receipt).value_or(Time())};
    if (message.getDataType() == kWheelTicks) {
      if (reader_.read(message, ticks_)) adapter.add(ticks_, receipt, sender);
    } else if (message.getDataType() == kSteering) {
      if (reader_.read(message, angle_)) adapter.add(axleOf(message.getTopic()), angle_, receipt, sender);
    } else if (reader_.read(message, joints_)) {
      adapter.add(joints_, receipt, sender);
    } else {
      return false;
    }
    return true;
  }

 private:
  Axle axleOf(const std::string& topic) const {
    const bool front =
        std::find(front_steering_.begin(), front_steering_.end(), topic) != front_steering_.end();
    return front ? Axle::kFront : Axle::kRear;
  }

  const std::string kWheelTicks{ros::message_traits::datatype<WheelTicks>()};
  const std::string kSteering{ros::message_traits::datatype<SteeringAngle>()};
  std::vector<std::string> front_steering_;  ///< the topic's spellings
  MessageReader reader_;
  CallerNames callers_;
  WheelTicks ticks_;
  SteeringAngle angle_;
  RawJointState joints_;
};

/// Why messages gave no pose: what was dropped, and why; "; 3 messages dropped: ...".
std::string reasons(const InputCounts& counts);

}  // namespace bs_car_odometry::tools
