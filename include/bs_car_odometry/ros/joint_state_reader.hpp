#pragma once

#include "bs_car_odometry/core/vehicle.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"
#include "bs_car_odometry/ros/raw_message.hpp"

#include <ros/time.h>
#include <sensor_msgs/JointState.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace bs_car_odometry {

using RawJointState = RawMessage<sensor_msgs::JointState>;

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
