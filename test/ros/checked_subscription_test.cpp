// Messages that are shorter than their lengths claim, as roscpp hands them over.

#include "bs_car_odometry/ros/checked_subscription.hpp"

#include "bs_car_odometry/WheelTicks.h"

#include <gmock/gmock.h>

#include <memory>
#include <optional>
#include <typeinfo>
#include <vector>

namespace bs_car_odometry::testing {
namespace {

using Callback = CheckedCallback<WheelTicks>;

/// As a subscription does with bytes that have come over a connection.
/// @return what it was called with, if it was
std::optional<WheelTicks> received(const std::shared_ptr<CutMessages>& cut, std::vector<std::uint8_t> bytes) {
  std::optional<WheelTicks> received;
  const auto callback = std::make_unique<Callback>(
      [&received](const Callback::Base::Event& event) { received = *event.getMessage(); }, cut);
  const auto header = boost::make_shared<ros::M_string>();
  const ros::VoidConstPtr message =
      callback->deserialize({bytes.data(), static_cast<std::uint32_t>(bytes.size()), header});
  if (!message) return std::nullopt;
  ros::SubscriptionCallbackHelperCallParams call;
  call.event = ros::MessageEvent<const void>(message, header, ros::Time(1.0), true, {});
  callback->call(call);
  return received;
}

std::vector<std::uint8_t> bytesOf(const WheelTicks& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

TEST(CheckedSubscription, X1_tellsWholeMessagesFromThoseThatAreCut) {
  WheelTicks message;
  message.header.frame_id = "wheels";
  message.front_left = 42;
  const std::vector<std::uint8_t> bytes = bytesOf(message);
  const auto cut = std::make_shared<CutMessages>();
  const std::optional<WheelTicks> whole = received(cut, bytes);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->front_left, 42);
  EXPECT_EQ(cut->take(), 0u);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(received(cut, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}));
  EXPECT_EQ(cut->take(), bytes.size());
  EXPECT_EQ(cut->take(), 0u);
}

/// roscpp compares the types, and makes bytes of a message for every other.
TEST(CheckedSubscription, takesMessagesOfItsProcessAsTheyAre) {
  EXPECT_EQ(std::make_unique<Callback>(Callback::Base::Callback(), nullptr)->getTypeInfo(),
            typeid(WheelTicks));
}

}  // namespace
}  // namespace bs_car_odometry::testing
