// O8: which frames a message on /tf connects, whatever its lengths claim.

#include "bs_car_odometry/ros/transform_reader.hpp"
#include "bs_car_odometry/ros/laser_input.hpp"

#include <gtest/gtest.h>

#include <cstring>
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

/// As the callback of a subscriber gets it; null where it is not called.
boost::shared_ptr<const tf2_msgs::TFMessage> received(std::vector<std::uint8_t> bytes) {
  TransformsCallback subscription{TransformsCallback::Callback()};
  ros::SubscriptionCallbackHelperDeserializeParams wire;
  wire.buffer = bytes.data();
  wire.length = static_cast<std::uint32_t>(bytes.size());
  return boost::static_pointer_cast<const tf2_msgs::TFMessage>(subscription.deserialize(wire));
}

tf2_msgs::TFMessage transforms(const Frames& frames) { return *received(bytesOf(frames)); }

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
    EXPECT_FALSE(received({whole.begin(), whole.begin() + static_cast<long>(length)}));
}

TEST(Transforms, O8_lengths_that_lie_do_no_harm) {
  const std::vector<std::uint8_t> whole = bytesOf({{"map", "odom"}, {"odom", "base_link"}});
  for (std::size_t i = 0; i + 4 <= whole.size(); ++i) {
    std::vector<std::uint8_t> lying = whole;
    for (std::size_t byte = 0; byte < 4; ++byte) lying[i + byte] = 0xff;
    if (const auto message = received(lying)) parentOf("base_link", *message);
  }
}

/// Only then does roscpp pass on what the node itself publishes as it is.
TEST(Transforms, O8_the_type_of_the_subscription_is_the_messages_own) {
  TransformsCallback subscription{TransformsCallback::Callback()};
  EXPECT_EQ(subscription.getTypeInfo(), typeid(tf2_msgs::TFMessage));
}

TEST(Transforms, C9_are_read_as_their_own_reader_reads_them) {
  const std::vector<std::uint8_t> sent = bytesOf({{"map", "odom"}, {"", "base_link"}});
  const auto read = readTransforms(ByteReader(sent));
  ASSERT_TRUE(read);
  ASSERT_EQ(read->transforms.size(), 2u);
  EXPECT_EQ(read->transforms[0].header.frame_id, "map");
  EXPECT_EQ(read->transforms[1].child_frame_id, "base_link");
  std::vector<std::uint8_t> numbers = bytesOf({{"", ""}});
  for (std::size_t i = 0; i < 7; ++i) {
    const double number = 1.5 * static_cast<double>(i + 1);
    std::memcpy(numbers.data() + numbers.size() - (7 - i) * sizeof number, &number, sizeof number);
  }
  const geometry_msgs::Transform transform = readTransforms(ByteReader(numbers))->transforms[0].transform;
  EXPECT_EQ(transform.translation.x, 1.5);
  EXPECT_EQ(transform.rotation.x, 6.0);
  EXPECT_EQ(transform.rotation.w, 10.5);
}

TEST(Transforms, X1_none_are_read_where_lengths_lie) {
  const std::vector<std::uint8_t> good = bytesOf({{"map", "odom"}, {"odom", "base_link"}});
  for (std::size_t length = 0; length < good.size(); ++length)
    EXPECT_FALSE(readTransforms(ByteReader(std::vector<std::uint8_t>(good.begin(), good.begin() + length))));
  for (const std::uint32_t lie : {3u, 0x00ffffffu, 0xffffffffu}) {
    std::vector<std::uint8_t> lying = good;
    std::memcpy(lying.data(), &lie, sizeof lie);
    EXPECT_FALSE(readTransforms(ByteReader(lying))) << lie;
  }
}

/// tf's own arithmetic on stamps throws at the end of their range.
TEST(Transforms, X1_stamps_that_tf_cannot_bear_are_as_good_as_absent) {
  LaserMountFinder finder("base_link", "laser");
  tf2_msgs::TFMessage message;
  message.transforms.resize(2);
  for (geometry_msgs::TransformStamped& transform : message.transforms) {
    transform.header.frame_id = "base_link";
    transform.child_frame_id = "mast";
    transform.transform.rotation.w = 1.0;
    transform.header.stamp.sec = 0xffffffffu;
  }
  EXPECT_NO_THROW(finder.add(message));
  message.transforms.resize(1);
  message.transforms[0].child_frame_id = "laser";
  message.transforms[0].transform.translation.x = 2.0;
  finder.add(message);
  ASSERT_TRUE(finder.mount());
  EXPECT_EQ(finder.mount()->x, 2.0);
}

geometry_msgs::TransformStamped link(const std::string& parent, const std::string& child) {
  geometry_msgs::TransformStamped link;
  link.header.frame_id = parent;
  link.child_frame_id = child;
  link.transform.rotation.w = 1.0;
  return link;
}

void add(LaserMountFinder& finder, const geometry_msgs::TransformStamped& link) {
  tf2_msgs::TFMessage message;
  message.transforms = {link};
  finder.add(message);
}

/// tf writes a line for each link that it refuses, and whoever reads the log is flooded.
TEST(Transforms, X1_links_that_tf_would_complain_of_are_not_shown_to_it) {
  std::vector<geometry_msgs::TransformStamped> bad = {link("", "laser"), link("base_link", ""),
                                                      link("/", "laser"), link("laser", "/laser")};
  for (const double number : {std::numeric_limits<double>::quiet_NaN(), 1e200}) {
    bad.push_back(link("base_link", "laser"));
    bad.back().transform.rotation.w = number;
  }
  bad.push_back(link("base_link", "laser"));
  bad.back().transform.translation.z = std::numeric_limits<double>::infinity();
  geometry_msgs::TransformStamped old = link("far", "away");
  old.header.stamp = ros::Time(1000.0);
  bad.push_back(old);
  old.header.stamp = ros::Time(1.0);
  bad.push_back(old);
  LaserMountFinder finder("base_link", "laser");
  ::testing::internal::CaptureStderr();
  for (const auto& transform : bad) add(finder, transform);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_FALSE(finder.mount());
}

TEST(Transforms, X1_frames_without_end_are_not_kept) {
  LaserMountFinder finder("base_link", "laser");
  add(finder, link("base_link", "mast"));
  for (int i = 0; i < 2000; ++i) add(finder, link("mast", "frame_" + std::to_string(i)));
  add(finder, link("mast", "laser"));
  EXPECT_FALSE(finder.mount()) << "there was no room for one more";
  LaserMountFinder patient("base_link", "frame_900");
  add(patient, link("base_link", "mast"));
  for (int i = 0; i < 2000 && !patient.mount(); ++i) add(patient, link("mast", "frame_" + std::to_string(i)));
  EXPECT_TRUE(patient.mount());
}

TEST(Transforms, X1_a_laser_beyond_what_laser_x_may_be_is_not_on_the_car) {
  LaserMountFinder finder("base_link", "laser");
  geometry_msgs::TransformStamped mount = link("base_link", "laser");
  mount.transform.translation.x = 1e9;
  add(finder, mount);
  EXPECT_FALSE(finder.mount());
  mount.transform.translation.x = 2.0;
  add(finder, mount);
  EXPECT_TRUE(finder.mount());
}

}  // namespace
}  // namespace bs_car_odometry
