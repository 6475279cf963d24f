#pragma once

#include "bs_car_odometry/ros/traits_of.hpp"

#include <ros/message_traits.h>
#include <ros/serialization.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace bs_car_odometry {

/// A message as it came over the wire. Its own reader allocates what its length fields claim before it looks
/// whether so much is there: 40 bytes can ask for gigabytes. This one copies the bytes that are there, and a
/// ByteReader checks every length against them.
template <typename Message>
struct RawMessage {
  std::vector<std::uint8_t> bytes;
};

/// Reads little-endian values off a byte range and remembers whether everything was there.
class ByteReader {
 public:
  explicit ByteReader(const std::vector<std::uint8_t>& bytes) : next_(bytes.data()), left_(bytes.size()) {}
  explicit ByteReader(std::string_view bytes)
      : next_(reinterpret_cast<const std::uint8_t*>(bytes.data())), left_(bytes.size()) {}

  template <typename T>
  T value() {
    T value{};
    if (!skip(sizeof(T))) return value;
    std::memcpy(&value, next_ - sizeof(T), sizeof(T));
    return value;
  }

  std::string string() { return std::string(block()); }

  /// The bytes behind their length, where they are.
  std::string_view block() {
    const auto length = value<std::uint32_t>();
    if (!skip(length)) return {};
    return {reinterpret_cast<const char*>(next_ - length), length};
  }

  /// Number of elements that follow, each at least `smallest` bytes long; 0 when so many cannot be there.
  std::uint32_t count(std::size_t smallest) {
    const auto count = value<std::uint32_t>();
    if (count > left_ / smallest) sound_ = false;
    return sound_ ? count : 0;
  }

  bool skip(std::size_t size) {
    sound_ = sound_ && size <= left_;
    if (!sound_) return false;
    next_ += size;
    left_ -= size;
    return true;
  }

  bool sound() const { return sound_; }
  std::size_t left() const { return left_; }

 private:
  const std::uint8_t* next_;
  std::size_t left_;
  bool sound_{true};
};

}  // namespace bs_car_odometry

namespace ros {
namespace message_traits {

template <typename Message>
struct MD5Sum<bs_car_odometry::RawMessage<Message>>
    : bs_car_odometry::TraitOf<MD5Sum, Message, bs_car_odometry::RawMessage<Message>> {};
template <typename Message>
struct DataType<bs_car_odometry::RawMessage<Message>>
    : bs_car_odometry::TraitOf<DataType, Message, bs_car_odometry::RawMessage<Message>> {};
template <typename Message>
struct Definition<bs_car_odometry::RawMessage<Message>>
    : bs_car_odometry::TraitOf<Definition, Message, bs_car_odometry::RawMessage<Message>> {};
template <typename Message>
struct IsMessage<bs_car_odometry::RawMessage<Message>> : TrueType {};

}  // namespace message_traits

namespace serialization {

template <typename Message>
struct Serializer<bs_car_odometry::RawMessage<Message>> {
  template <typename Stream>
  static void read(Stream& stream, bs_car_odometry::RawMessage<Message>& message) {
    const std::uint32_t length = stream.getLength();
    const std::uint8_t* begin = stream.advance(length);
    message.bytes.assign(begin, begin + length);
  }
};

}  // namespace serialization
}  // namespace ros
