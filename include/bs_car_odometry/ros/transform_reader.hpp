#pragma once

#include "bs_car_odometry/ros/raw_message.hpp"

#include <tf2_msgs/TFMessage.h>

#include <optional>
#include <string>

namespace bs_car_odometry {

/// The beginning of a message on /tf: some hundred transforms, so that the work is bounded.
using RawTransforms = RawMessage<tf2_msgs::TFMessage, 16384>;

/// Name of the frame that the message puts a frame into; none when it does not speak of that. A leading slash
/// does not matter.
std::optional<std::string> parentOf(const std::string& child, const RawTransforms& message);

/// All transforms of a message; none when a length does not fit the bytes.
std::optional<tf2_msgs::TFMessage> readTransforms(const RawMessage<tf2_msgs::TFMessage>& message);

}  // namespace bs_car_odometry
