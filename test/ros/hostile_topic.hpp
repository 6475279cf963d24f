#pragma once

#include "any_bytes.hpp"
#include "hostile_bytes.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <ros/ros.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry::testing {

constexpr std::uint64_t kHostileSeed = 20;
constexpr int kBatch = 40;  // messages of each topic between two good ones, fewer than the queues hold

/// A topic on which good messages are sent, and spoiled ones.
template <typename Message>
class HostileTopic {
 public:
  /// @param stream  of random numbers: one of its own for each topic
  HostileTopic(const std::string& name, std::uint64_t stream) : hostile_(kHostileSeed + stream) {
    publisher_ = ros::NodeHandle().advertise<AnyBytes<Message>>(name, 5000);
  }

  void send(const Message& message) { publish(bytesOf(message)); }
  void sendSpoiled(const Message& good) {
    publish(hostile_.spoil(bytesOf(good)));
    ++spoiled_;
  }

  /// Of a drive in the past: a stamp between it and the clock would be believed, and the drive be over. Half
  /// a second ahead it may be.
  void sendSpoiledOfThePast(const Message& good) {
    const std::vector<std::uint8_t> good_bytes = bytesOf(good);
    std::vector<std::uint8_t> bytes = hostile_.spoil(good_bytes);
    const std::optional<Time> stamp = stampIn(bytes);
    const Time latest = *toTime(good.header.stamp) + std::chrono::milliseconds(500);
    const Time clock = *toTime(ros::Time::now()) + std::chrono::seconds(1);
    if (stamp && *stamp > latest && *stamp < clock)
      std::copy_n(good_bytes.begin() + kStamp, kStampBytes, bytes.begin() + kStamp);
    publish(bytes);
    ++spoiled_;
  }

  bool connected(std::uint32_t listeners = 1) const { return publisher_.getNumSubscribers() >= listeners; }
  int spoiled() const { return spoiled_; }

 private:
  static constexpr std::size_t kStamp = 4;  // behind header.seq
  static constexpr std::size_t kStampBytes = 8;

  static std::optional<Time> stampIn(const std::vector<std::uint8_t>& bytes) {
    if (bytes.size() < kStamp + kStampBytes) return std::nullopt;
    ros::Time stamp;
    std::memcpy(&stamp.sec, bytes.data() + kStamp, sizeof stamp.sec);
    std::memcpy(&stamp.nsec, bytes.data() + kStamp + sizeof stamp.sec, sizeof stamp.nsec);
    return toTime(stamp);
  }

  void publish(const std::vector<std::uint8_t>& bytes) { publisher_.publish(AnyBytes<Message>{bytes}); }

  HostileBytes hostile_;
  ros::Publisher publisher_;
  int spoiled_{0};
};

}  // namespace bs_car_odometry::testing
