#pragma once

#include "bag_input.hpp"
#include "tool.hpp"

#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"
#include "bs_car_odometry/ros/odometry_adapter.hpp"

#include <rosbag/view.h>

#include <algorithm>
#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// The topics that the odometry reads with these parameters.
class InputTopics {
 public:
  InputTopics(const Parameters& parameters, const TopicNames& names);

  /// One topic more.
  void require(const std::string& name, const std::string& type);

  const std::vector<WantedTopic>& required() const { return required_; }

  /// Of all that is required.
  std::vector<std::string> spellings() const;

 private:
  const TopicNames& names_;
  std::vector<WantedTopic> required_;
};

/// Gives recorded wheels and angles to an OdometryAdapter or a CalibrationAdapter.
class InputFeed {
 public:
  explicit InputFeed(const TopicNames& names) : front_steering_(names.spellings("front_steering")) {}

  /// @return false for a message that is none of the odometry's inputs
  template <typename Adapter>
  bool feed(const rosbag::MessageInstance& message, Adapter& adapter) const {
    const ros::Time& receipt = message.getTime();
    const std::string publisher = message.getCallerId();
    const Sender sender{publisher, toTime(receipt).value_or(Time())};
    if (message.getDataType() == kWheelTicks) {
      if (const auto ticks = message.instantiate<WheelTicks>()) adapter.add(*ticks, receipt, sender);
    } else if (message.getDataType() == kSteering) {
      if (const auto angle = message.instantiate<SteeringAngle>())
        adapter.add(axleOf(message.getTopic()), *angle, receipt, sender);
    } else if (const auto joints = message.instantiate<RawJointState>()) {
      adapter.add(*joints, receipt, sender);
    } else {
      return false;
    }
    return true;
  }

 private:
  Axle axleOf(const std::string& topic) const {
    const bool front =
        std::find(front_steering_.begin(), front_steering_.end(), topic) != front_steering_.end();
    return front ? Axle::kFront : Axle::kRear;
  }

  const std::string kWheelTicks{ros::message_traits::datatype<WheelTicks>()};
  const std::string kSteering{ros::message_traits::datatype<SteeringAngle>()};
  std::vector<std::string> front_steering_;  ///< the topic's spellings
};

/// Why messages gave no pose: what was dropped, and why; "; 3 messages dropped: ...".
std::string reasons(const InputCounts& counts);

}  // namespace bs_car_odometry::tools
