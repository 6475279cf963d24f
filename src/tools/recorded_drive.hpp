#pragma once

#include "bag_messages.hpp"
#include "bs_car_odometry/core/se2.hpp"
#include "bs_car_odometry/core/time.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"
#include "bs_car_odometry/ros/joint_state_reader.hpp"
#include "csv_recording.hpp"
#include "tool.hpp"

#include <ros/time.h>

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace bs_car_odometry::tools {

/// One input of the odometry, with the time of its receipt.
struct InputMessage {
  ros::Time receipt;
  std::variant<WheelTicks, AxleReading, RawJointState> content;
};

/// Where the tracked point of the car truly was.
struct TruePose {
  Time stamp;
  Pose2 pose;
};

/// Truth between two poses.
struct InterpolatedPose {
  Pose2 pose;
  double variance{1.0};  ///< of its error, in units of that of one pose: 1/2 midway between two
};

/// A drive with its truth, both in time order.
struct RecordedDrive {
  std::string name;
  std::vector<InputMessage> inputs;
  std::vector<TruePose> truth;
  Pose2 tracked_point;  ///< whose pose the truth is, in base_link

  /// Truth by linear interpolation; none outside it and inside gaps longer than `max_gap`.
  std::optional<InterpolatedPose> truthAt(Time stamp, Duration max_gap) const;
};

/// Topics that readDrive() looks for.
std::vector<std::string> driveTopics();

/// Reads a bag with wheels, the steering that the vehicle needs, and `ground_truth` (of base_link) or else
/// `laser_pose` (of the point that the parameters `laser` name).
/// @throws InputError
RecordedDrive readDrive(const std::string& bag, const Parameters& parameters, const TopicNames& topics);

/// The same of a recording read from CSV, whose poses are those of base_link.
/// @throws InputError when it has no poses
RecordedDrive makeDrive(const std::string& name, const Recording& recording);

}  // namespace bs_car_odometry::tools
