#include "recorded_drive.hpp"

#include "bag_input.hpp"

#include "bs_car_odometry/calibration/planar.hpp"
#include "bs_car_odometry/core/odometry_configuration.hpp"
#include "bs_car_odometry/ros/conversions.hpp"

#include <algorithm>
#include <iterator>
#include <memory>

namespace bs_car_odometry::tools {

namespace {

bool earlier(const TruePose& a, const TruePose& b) { return a.stamp < b.stamp; }

/// Adds a pose that has a stamp and is one; others are as good as absent. It shows the car `late` before its
/// stamp.
void addTruth(const ros::Time& stamp, const geometry_msgs::Pose& pose, Duration late, RecordedDrive& drive) {
  const std::optional<Time> time = toTime(stamp);
  const std::optional<Pose2> planar = toPose(pose);
  if (time && planar) drive.truth.push_back({*time - late, *planar});
}

/// Puts the truth in order, one pose for each stamp.
void sortTruth(RecordedDrive& drive) {
  std::stable_sort(drive.truth.begin(), drive.truth.end(), earlier);
  const auto same = [](const TruePose& a, const TruePose& b) { return a.stamp == b.stamp; };
  drive.truth.erase(std::unique(drive.truth.begin(), drive.truth.end(), same), drive.truth.end());
  if (drive.truth.size() < 2)
    throw InputError(drive.name + " has no true poses: fewer than two on ground_truth or laser_pose");
}

/// Reads the messages of one bag.
class DriveReader {
 public:
  DriveReader(const std::string& path, const Parameters& parameters, const TopicNames& topics)
      : path_(path), parameters_(parameters), topics_(topics), bag_(openBag(path)) {}

  RecordedDrive read() {
    RecordedDrive drive;
    drive.name = path_;
    requireInputs();
    const bool truth = has("ground_truth");
    if (!truth) drive.tracked_point = laserMount();
    const std::string truth_topic = truth ? "ground_truth" : "laser_pose";
    require(truth_topic, truth ? "nav_msgs/Odometry" : "geometry_msgs/PoseWithCovarianceStamped");
    const rosbag::TopicQuery truth_query(topics_.spellings(truth_topic));
    readMessages(path_, [&] {
      for (const rosbag::MessageInstance& message : rosbag::View(*bag_, query())) addInput(message, drive);
      for (const rosbag::MessageInstance& message : rosbag::View(*bag_, truth_query))
        addTruth(message, drive);
    });
    sortTruth(drive);
    return drive;
  }

 private:
  bool has(const std::string& name) const {
    const rosbag::TopicQuery named(topics_.spellings(name));
    return rosbag::View(*bag_, named).size() > 0;
  }

  void require(const std::string& name, const std::string& type) const {
    requireTopics(*bag_, path_, {{topics_.spellings(name), type}});
  }

  void requireInput(const std::string& name, const std::string& type) {
    require(name, type);
    const std::vector<std::string> spellings = topics_.spellings(name);
    inputs_.insert(inputs_.end(), spellings.begin(), spellings.end());
  }

  void requireInputs() {
    if (parameters_.input == InputSource::kJointStates)
      return requireInput("joint_states", "sensor_msgs/JointState");
    const PerAxle<bool> needed = steeringNeeded(parameters_.vehicle, parameters_.odometry);
    requireInput("wheel_ticks", "bs_car_odometry/WheelTicks");
    if (needed.front) requireInput("front_steering", "bs_car_odometry/SteeringAngle");
    if (needed.rear) requireInput("rear_steering", "bs_car_odometry/SteeringAngle");
  }

  rosbag::TopicQuery query() const { return rosbag::TopicQuery(inputs_); }

  Pose2 laserMount() const {
    const LaserMount& laser = parameters_.laser;
    if (!laser.frame.empty())
      throw InputError(path_ + " has no ground_truth, and laser_pose is that of the frame '" + laser.frame +
                       "': give laser/x, laser/y and laser/yaw instead of laser/frame");
    return calibration::mountOf(laser);
  }

  void addInput(const rosbag::MessageInstance& message, RecordedDrive& drive) const {
    if (const auto ticks = message.instantiate<WheelTicks>()) {
      drive.inputs.push_back({message.getTime(), *ticks});
    } else if (const auto angle = message.instantiate<SteeringAngle>()) {
      const Axle axle = topics_.matches(message.getTopic(), "front_steering") ? Axle::kFront : Axle::kRear;
      drive.inputs.push_back({message.getTime(), AxleReading{axle, *angle}});
    } else if (const auto joints = message.instantiate<RawJointState>()) {
      drive.inputs.push_back({message.getTime(), *joints});
    }
  }

  void addTruth(const rosbag::MessageInstance& message, RecordedDrive& drive) const {
    if (const auto odometry = message.instantiate<nav_msgs::Odometry>())
      tools::addTruth(odometry->header.stamp, odometry->pose.pose, Duration::zero(), drive);
    else if (const auto pose = message.instantiate<geometry_msgs::PoseWithCovarianceStamped>())
      tools::addTruth(pose->header.stamp, pose->pose.pose, durationFromSeconds(parameters_.laser.time_offset),
                      drive);
  }

  std::string path_;
  const Parameters& parameters_;
  const TopicNames& topics_;
  std::unique_ptr<rosbag::Bag> bag_;
  std::vector<std::string> inputs_;
};

}  // namespace

std::optional<InterpolatedPose> RecordedDrive::truthAt(Time stamp, Duration max_gap) const {
  const auto after = std::lower_bound(truth.begin(), truth.end(), TruePose{stamp, {}}, earlier);
  if (after == truth.end()) return std::nullopt;
  if (after->stamp == stamp) return InterpolatedPose{after->pose, 1.0};
  if (after == truth.begin()) return std::nullopt;
  const auto before = std::prev(after);
  if (after->stamp - before->stamp > max_gap) return std::nullopt;
  const double share = toSeconds(stamp - before->stamp) / toSeconds(after->stamp - before->stamp);
  const Pose2& a = before->pose;
  const Pose2& b = after->pose;
  const Pose2 between{a.x + share * (b.x - a.x), a.y + share * (b.y - a.y),
                      a.yaw + share * wrapAngle(b.yaw - a.yaw)};
  return InterpolatedPose{between, share * share + (1.0 - share) * (1.0 - share)};
}

std::vector<std::string> driveTopics() {
  return {"wheel_ticks", "front_steering", "rear_steering", "joint_states", "ground_truth", "laser_pose"};
}

RecordedDrive readDrive(const std::string& bag, const Parameters& parameters, const TopicNames& topics) {
  return DriveReader(bag, parameters, topics).read();
}

RecordedDrive makeDrive(const std::string& name, const Recording& recording) {
  RecordedDrive drive;
  drive.name = name;
  for (const SteeringAngle& angle : recording.front_steering)
    drive.inputs.push_back({angle.header.stamp, AxleReading{Axle::kFront, angle}});
  for (const SteeringAngle& angle : recording.rear_steering)
    drive.inputs.push_back({angle.header.stamp, AxleReading{Axle::kRear, angle}});
  for (const WheelTicks& ticks : recording.wheels) drive.inputs.push_back({ticks.header.stamp, ticks});
  // Of readings of one instant, the steering comes first, as in a bag.
  std::stable_sort(drive.inputs.begin(), drive.inputs.end(),
                   [](const InputMessage& a, const InputMessage& b) { return a.receipt < b.receipt; });
  for (const nav_msgs::Odometry& pose : recording.ground_truth)
    addTruth(pose.header.stamp, pose.pose.pose, Duration::zero(), drive);
  sortTruth(drive);
  return drive;
}

}  // namespace bs_car_odometry::tools
