#pragma once

#include "bs_car_odometry/ros/traits_of.hpp"

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <cstdint>
#include <cstring>
#include <vector>

namespace bs_car_odometry::testing {

/// Bytes that claim to be a message of this type.
template <typename Message>
struct AnyBytes {
  std::vector<std::uint8_t> bytes;
};

template <typename Message>
std::vector<std::uint8_t> bytesOf(const Message& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

}  // namespace bs_car_odometry::testing

namespace ros {
namespace message_traits {
template <typename Message>
struct MD5Sum<bs_car_odometry::testing::AnyBytes<Message>>
    : bs_car_odometry::TraitOf<MD5Sum, Message, bs_car_odometry::testing::AnyBytes<Message>> {};
template <typename Message>
struct DataType<bs_car_odometry::testing::AnyBytes<Message>>
    : bs_car_odometry::TraitOf<DataType, Message, bs_car_odometry::testing::AnyBytes<Message>> {};
template <typename Message>
struct Definition<bs_car_odometry::testing::AnyBytes<Message>>
    : bs_car_odometry::TraitOf<Definition, Message, bs_car_odometry::testing::AnyBytes<Message>> {};
}  // namespace message_traits
namespace serialization {
template <typename Message>
struct Serializer<bs_car_odometry::testing::AnyBytes<Message>> {
  template <typename Stream>
  static void write(Stream& stream, const bs_car_odometry::testing::AnyBytes<Message>& message) {
    std::memcpy(stream.advance(static_cast<std::uint32_t>(message.bytes.size())), message.bytes.data(),
                message.bytes.size());
  }
  static std::uint32_t serializedLength(const bs_car_odometry::testing::AnyBytes<Message>& message) {
    return static_cast<std::uint32_t>(message.bytes.size());
  }
};
}  // namespace serialization
}  // namespace ros
