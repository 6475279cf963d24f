// O8: which frames a message on /tf connects, whatever its lengths claim.

#include "bs_car_odometry/ros/transform_reader.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace bs_car_odometry {
namespace {

using Frames = std::vector<std::pair<std::string, std::string>>;

std::vector<std::uint8_t> bytesOf(const Frames& frames) {
  tf2_msgs::TFMessage message;
  for (const auto& [parent, child] : frames) {
    message.transforms.emplace_back();
    message.transforms.back().header.frame_id = parent;
    message.transforms.back().child_frame_id = child;
  }
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

/// As the callback of a subscriber gets it.
RawTransforms received(std::vector<std::uint8_t> bytes) {
  RawTransforms message;
  ros::serialization::IStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::deserialize(stream, message);
  return message;
}

RawTransforms transforms(const Frames& frames) { return received(bytesOf(frames)); }

TEST(Transforms, O8_the_frame_is_found_wherever_it_stands) {
  EXPECT_EQ(parentOf("base_link", transforms({{"odom", "base_link"}})), "odom");
  EXPECT_EQ(parentOf("base_link", transforms({{"map", "odom"}, {"map", "base_link"}})), "map");
  EXPECT_EQ(parentOf("base_link", transforms({{"/odom", "/base_link"}})), "/odom");
  EXPECT_FALSE(parentOf("base_link", transforms({{"base_link", "laser"}, {"map", "odom"}})));
  EXPECT_FALSE(
      parentOf("base_link", transforms({{"odom", "base_link_2"}, {"odom", "ase_link"}, {"odom", ""}})));
  EXPECT_FALSE(parentOf("base_link", transforms({})));
}

TEST(Transforms, O8_a_message_cut_anywhere_does_no_harm) {
  const std::vector<std::uint8_t> whole = bytesOf({{"map", "odom"}, {"odom", "base_link"}});
  for (std::size_t length = 0; length < whole.size(); ++length)
    EXPECT_FALSE(parentOf("base_link", received({whole.begin(), whole.begin() + static_cast<long>(length)})));
}

TEST(Transforms, O8_lengths_that_lie_do_no_harm) {
  const std::vector<std::uint8_t> whole = bytesOf({{"map", "odom"}, {"odom", "base_link"}});
  for (std::size_t i = 0; i + 4 <= whole.size(); ++i) {
    std::vector<std::uint8_t> lying = whole;
    for (std::size_t byte = 0; byte < 4; ++byte) lying[i + byte] = 0xff;
    parentOf("base_link", received(lying));
  }
}

TEST(Transforms, O8_the_work_is_bounded) {
  const Frames many(100000, {"map", "somewhere"});
  EXPECT_LE(transforms(many).bytes.size(), 16384u);
  EXPECT_FALSE(parentOf("base_link", transforms(many)));
}

}  // namespace
}  // namespace bs_car_odometry
