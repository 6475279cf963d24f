#pragma once

#include "bs_car_odometry/core/vehicle.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <ros/time.h>
#include <sensor_msgs/JointState.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace bs_car_odometry {

/// A `sensor_msgs/JointState` as it came over the wire. The message's own reader allocates what its length
/// fields claim before it looks whether so much is there: 40 bytes can ask for gigabytes. This one copies the
/// bytes that are there, and readJointState() checks every length against them.
struct RawJointState {
  std::vector<std::uint8_t> bytes;
};

/// Stamp, names and positions of a joint state.
struct JointPositions {
  ros::Time stamp;
  std::vector<std::pair<std::string, double>> positions;  ///< [rad]

  /// Position of a joint; none when the message does not hold it.
  std::optional<double> operator[](const std::string& joint) const;
};

/// None when a length does not fit the bytes, or names and positions differ in number.
std::optional<JointPositions> readJointState(const RawJointState& message);

/// Readings of the axles' angles [rad], before scale and offset, that the steering joints give; none for an
/// axle whose joints are not in the message. Two joints of an axle are its left and right wheel: each gives
/// an angle of the axle (docs/model.md, K3), the axle has their mean.
PerAxle<std::optional<double>> axleReadings(const Vehicle& vehicle, const JointNames& joints,
                                            const JointPositions& positions);

}  // namespace bs_car_odometry

namespace ros {
namespace message_traits {

template <>
struct MD5Sum<bs_car_odometry::RawJointState> {
  static const char* value(const bs_car_odometry::RawJointState& /*message*/) { return value(); }
  static const char* value() { return MD5Sum<sensor_msgs::JointState>::value(); }
};
template <>
struct DataType<bs_car_odometry::RawJointState> {
  static const char* value(const bs_car_odometry::RawJointState& /*message*/) { return value(); }
  static const char* value() { return DataType<sensor_msgs::JointState>::value(); }
};
template <>
struct Definition<bs_car_odometry::RawJointState> {
  static const char* value(const bs_car_odometry::RawJointState& /*message*/) { return value(); }
  static const char* value() { return Definition<sensor_msgs::JointState>::value(); }
};
template <>
struct IsMessage<bs_car_odometry::RawJointState> : TrueType {};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<bs_car_odometry::RawJointState> {
  template <typename Stream>
  static void read(Stream& stream, bs_car_odometry::RawJointState& message) {
    const std::uint32_t length = stream.getLength();
    const std::uint8_t* begin = stream.advance(length);
    message.bytes.assign(begin, begin + length);
  }
};

}  // namespace serialization
}  // namespace ros
