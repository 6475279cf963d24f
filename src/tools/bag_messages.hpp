#pragma once

#include "read_ahead.hpp"
#include "tool.hpp"

#include "bs_car_odometry/CalibrationState.h"
#include "bs_car_odometry/SteeringAngle.h"
#include "bs_car_odometry/WheelTicks.h"
#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/joint_state_reader.hpp"
#include "bs_car_odometry/ros/publisher_watch.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/time.h>
#include <rosbag/view.h>

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace bs_car_odometry::tools {

/// A reading of one axle.
struct AxleReading {
  Axle axle{Axle::kFront};
  SteeringAngle message;
};

/// A message of a bag, with the time at which it was recorded.
struct BagMessage {
  ros::Time receipt;
  std::string publisher;  ///< name of the node
  /// The messages that come often are here by value, so that room is used again; nothing for other types.
  std::variant<std::monostate, WheelTicks, AxleReading, RawJointState,
               geometry_msgs::PoseWithCovarianceStampedConstPtr, CalibrationStateConstPtr>
      content;
};

/// Gives recorded wheels and angles to an OdometryAdapter or a CalibrationAdapter.
/// @return false for a message that is none of the odometry's inputs
template <typename Adapter>
bool giveInput(const BagMessage& message, Adapter& adapter) {
  const Sender sender{message.publisher, toTime(message.receipt).value_or(Time())};
  if (const auto* ticks = std::get_if<WheelTicks>(&message.content))
    adapter.add(*ticks, message.receipt, sender);
  else if (const auto* angle = std::get_if<AxleReading>(&message.content))
    adapter.add(angle->axle, angle->message, message.receipt, sender);
  else if (const auto* joints = std::get_if<RawJointState>(&message.content))
    adapter.add(*joints, message.receipt, sender);
  else
    return false;
  return true;
}

/// Names of the nodes that published a bag's messages, looked up once for each connection.
class CallerNames {
 public:
  const std::string& of(const rosbag::MessageInstance& message);

 private:
  std::vector<std::pair<boost::shared_ptr<ros::M_string>, std::string>> names_;
};

/// Takes the messages of a view out of its bag, one after the other.
class MessageReader {
 public:
  /// @param names  tell the front steering from the rear
  MessageReader(rosbag::View& view, const TopicNames& names);

  /// @return false at the end
  bool read(BagMessage& message);

  /// Room for the bytes of a message, for rosbag.
  std::uint8_t* advance(std::uint32_t size) {
    bytes_.resize(size);
    return bytes_.data();
  }

 private:
  void take(const rosbag::MessageInstance& instance, BagMessage& message);
  template <typename Message>
  bool deserialize(const rosbag::MessageInstance& instance, Message& message);
  Axle axleOf(const std::string& topic) const;

  rosbag::View::iterator position_;
  rosbag::View::iterator end_;
  std::vector<std::string> front_steering_;  ///< the topic's spellings
  CallerNames callers_;
  std::vector<std::uint8_t> bytes_;
};

/// The messages of a view, read ahead by a thread of their own: meanwhile nobody else may touch the bag.
class BagMessages {
 public:
  BagMessages(rosbag::View& view, const TopicNames& names)
      : reader_(view, names), ahead_([this](BagMessage& message) { return reader_.read(message); }) {}

  /// The next one, valid until the next call; nullptr at the end.
  /// @throws what rosbag throws for a damaged bag, after the messages before the damage
  const BagMessage* next() { return ahead_.next(); }

 private:
  MessageReader reader_;
  ReadAhead<BagMessage> ahead_;
};

}  // namespace bs_car_odometry::tools
