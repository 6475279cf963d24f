#pragma once

#include "bs_car_odometry/ros/raw_message.hpp"

#include <ros/subscription_callback_helper.h>
#include <tf2_msgs/TFMessage.h>

#include <optional>
#include <string>

namespace bs_car_odometry {

/// Name of the frame that the message puts a frame into; none when it does not speak of that. A leading slash
/// does not matter.
std::optional<std::string> parentOf(const std::string& child, const tf2_msgs::TFMessage& message);

/// All transforms of a message; none when a length does not fit the bytes.
std::optional<tf2_msgs::TFMessage> readTransforms(ByteReader reader);

/// Reads with readTransforms() what comes from elsewhere. The message's own type stays that of the
/// subscription, as with CheckedCallback: most of what comes is this process's own, and is passed on as it
/// is.
class TransformsCallback
    : public ros::SubscriptionCallbackHelperT<const ros::MessageEvent<const tf2_msgs::TFMessage>&> {
 public:
  explicit TransformsCallback(const Callback& callback);

  /// @return none where a length does not fit; nobody is called with it
  ros::VoidConstPtr deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& received) override;
};

}  // namespace bs_car_odometry
