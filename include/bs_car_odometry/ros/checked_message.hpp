#pragma once

#include "bs_car_odometry/ros/traits_of.hpp"

#include <ros/message_traits.h>
#include <ros/serialization.h>

namespace bs_car_odometry {

/// A message that may have been shorter than its lengths claim. Where its own reader throws at that, roscpp
/// writes a line into the log for each.
template <typename Message>
struct CheckedMessage {
  Message content;
  bool whole{false};  ///< else the content means nothing
};

}  // namespace bs_car_odometry

namespace ros {
namespace message_traits {

template <typename Message>
struct MD5Sum<bs_car_odometry::CheckedMessage<Message>>
    : bs_car_odometry::TraitOf<MD5Sum, Message, bs_car_odometry::CheckedMessage<Message>> {};
template <typename Message>
struct DataType<bs_car_odometry::CheckedMessage<Message>>
    : bs_car_odometry::TraitOf<DataType, Message, bs_car_odometry::CheckedMessage<Message>> {};
template <typename Message>
struct Definition<bs_car_odometry::CheckedMessage<Message>>
    : bs_car_odometry::TraitOf<Definition, Message, bs_car_odometry::CheckedMessage<Message>> {};
template <typename Message>
struct IsMessage<bs_car_odometry::CheckedMessage<Message>> : TrueType {};

}  // namespace message_traits

namespace serialization {

template <typename Message>
struct Serializer<bs_car_odometry::CheckedMessage<Message>> {
  template <typename Stream>
  static void read(Stream& stream, bs_car_odometry::CheckedMessage<Message>& message) {
    try {
      stream.next(message.content);
      message.whole = true;
    } catch (const StreamOverrunException&) {
      message.whole = false;
    }
  }
};

}  // namespace serialization
}  // namespace ros
