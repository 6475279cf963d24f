// Messages that are shorter than their lengths claim, as roscpp hands them over.

#include "bs_car_odometry/ros/checked_subscription.hpp"

#include "bs_car_odometry/WheelTicks.h"

#include <gmock/gmock.h>

#include <optional>
#include <typeinfo>
#include <vector>

namespace bs_car_odometry::testing {
namespace {

using Callback = CheckedCallback<WheelTicks>;

struct Received {
  int messages{0};
  int cut{0};
  std::optional<std::int64_t> front_left;
};

Callback callbackInto(Received& received) {
  return Callback([&received](const Callback::Event* event) {
    const WheelTicks* message = messageOf(event);
    if (!message) {
      ++received.cut;
      return;
    }
    ++received.messages;
    received.front_left = message->front_left;
  });
}

/// As a subscription does with bytes that have come over a connection.
void receive(Callback& callback, std::vector<std::uint8_t> bytes) {
  const auto header = boost::make_shared<ros::M_string>();
  const ros::VoidConstPtr message =
      callback.deserialize({bytes.data(), static_cast<std::uint32_t>(bytes.size()), header});
  if (!message) return;
  ros::SubscriptionCallbackHelperCallParams call;
  call.event = ros::MessageEvent<const void>(message, header, ros::Time(1.0), true, {});
  callback.call(call);
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
  Received received;
  Callback callback = callbackInto(received);
  receive(callback, bytes);
  EXPECT_EQ(received.front_left, 42);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    receive(callback, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)});
  EXPECT_EQ(received.messages, 1);
  EXPECT_EQ(received.cut, static_cast<int>(bytes.size()));
}

/// roscpp compares the types, and makes bytes of a message for every other.
TEST(CheckedSubscription, takesMessagesOfItsProcessAsTheyAre) {
  Received received;
  EXPECT_EQ(callbackInto(received).getTypeInfo(), typeid(WheelTicks));
}

}  // namespace
}  // namespace bs_car_odometry::testing
