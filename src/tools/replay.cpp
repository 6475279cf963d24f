#include "replay.hpp"

#include "bag_input.hpp"
#include "bag_writer.hpp"
#include "tum_writer.hpp"

#include "bs_car_odometry/OdometryStatus.h"
#include "bs_car_odometry/ros/odometry_adapter.hpp"
#include "bs_car_odometry/ros/verdicts.hpp"

#include <nav_msgs/Odometry.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <sstream>
#include <system_error>

namespace bs_car_odometry::tools {

namespace {

/// The output files; each appears under its name only when the replay has come to its end.
class ReplayOutput {
 public:
  ReplayOutput(const ReplayFiles& files, const Parameters& parameters, const OutputFrames& frames)
      : frames_(frames), publish_tf_(parameters.publish_tf) {
    if (!files.output.empty()) bag_.emplace(files.output);
    if (!files.tum.empty()) {
      tum_file_.emplace(files.tum);
      tum_.emplace(tum_file_->temporaryPath());
    }
    transforms_.transforms.resize(1);
  }

  void write(const OdometryUpdate& update) {
    ++updates_;
    if (tum_) tum_->write(update);
    if (!bag_) return;
    const ros::Time time = std::max(toRos(update.completed), ros::TIME_MIN);
    fillOdometry(update, frames_, odom_);
    bag_->write("odom", time, odom_);
    if (publish_tf_) {
      fillTransform(update, frames_, transforms_.transforms.front());
      bag_->write("/tf", time, transforms_);
    }
    fillStatus(update, frames_, status_);
    bag_->write("odometry_status", time, status_);
  }

  void commit() {
    if (bag_) bag_->commit();
    if (tum_) {
      tum_->close();
      tum_file_->commit();
    }
  }

  std::size_t updates() const { return updates_; }

 private:
  OutputFrames frames_;
  bool publish_tf_;
  std::optional<BagWriter> bag_;
  std::optional<AtomicOutput> tum_file_;  // outlives what writes it
  std::optional<TumWriter> tum_;
  nav_msgs::Odometry odom_;
  tf2_msgs::TFMessage transforms_;
  OdometryStatus status_;
  std::size_t updates_{0};
};

/// The topics that the odometry reads with these parameters.
class InputTopics {
 public:
  InputTopics(const Parameters& parameters, const PerAxle<bool>& steering_needed, const TopicNames& names)
      : names_(names), accept_calibration_(parameters.accept_calibration) {
    if (parameters.input == InputSource::kJointStates) {
      require("joint_states", "sensor_msgs/JointState");
      return;
    }
    require("wheel_ticks", "bs_car_odometry/WheelTicks");
    if (steering_needed.front) require("front_steering", "bs_car_odometry/SteeringAngle");
    if (steering_needed.rear) require("rear_steering", "bs_car_odometry/SteeringAngle");
  }

  const std::vector<WantedTopic>& required() const { return required_; }

  /// What is required, and poses that were set or calibrations that were accepted during the drive.
  rosbag::TopicQuery query() const {
    std::vector<std::string> spellings = names_.spellings("set_pose");
    for (const std::string& spelling : names_.spellings("calibration"))
      if (accept_calibration_) spellings.push_back(spelling);
    for (const WantedTopic& topic : required_)
      spellings.insert(spellings.end(), topic.spellings.begin(), topic.spellings.end());
    return rosbag::TopicQuery(spellings);
  }

 private:
  void require(const std::string& name, const std::string& type) {
    required_.push_back({names_.spellings(name), type});
  }

  const TopicNames& names_;
  bool accept_calibration_;
  std::vector<WantedTopic> required_;
};

/// Gives a recorded message to the adapter.
class MessageFeed {
 public:
  MessageFeed(OdometryAdapter& adapter, const TopicNames& names)
      : adapter_(adapter), front_steering_(names.spellings("front_steering")) {}

  void feed(const rosbag::MessageInstance& message) {
    const ros::Time& receipt = message.getTime();
    if (message.getDataType() == kWheelTicks) {
      if (const auto ticks = message.instantiate<WheelTicks>()) adapter_.add(*ticks, receipt);
    } else if (message.getDataType() == kSteering) {
      if (const auto angle = message.instantiate<SteeringAngle>())
        adapter_.add(axleOf(message.getTopic()), *angle, receipt);
    } else if (const auto joints = message.instantiate<RawJointState>()) {
      adapter_.add(*joints, receipt);
    } else if (const auto pose = message.instantiate<geometry_msgs::PoseWithCovarianceStamped>()) {
      const std::string refused = adapter_.setPose(*pose);
      if (!refused.empty()) warn("set_pose refused: " + refused);
    } else if (const auto calibration = message.instantiate<CalibrationState>()) {
      const std::string refused = adapter_.add(*calibration);
      if (!refused.empty()) warn("message on calibration refused: " + refused);
    }
  }

 private:
  const std::string kWheelTicks{ros::message_traits::datatype<WheelTicks>()};
  const std::string kSteering{ros::message_traits::datatype<SteeringAngle>()};
  Axle axleOf(const std::string& topic) const {
    const bool front =
        std::find(front_steering_.begin(), front_steering_.end(), topic) != front_steering_.end();
    return front ? Axle::kFront : Axle::kRear;
  }

  OdometryAdapter& adapter_;
  std::vector<std::string> front_steering_;  ///< the topic's spellings
};

void writeComplete(OdometryAdapter& adapter, const ros::Time& now, ReplayOutput& output) {
  while (const std::optional<OdometryUpdate> update = adapter.next(now)) output.write(*update);
}

/// Why a replay gave no pose: what was dropped, and why.
std::string reasons(const InputCounts& counts) {
  std::ostringstream text;
  for (std::size_t i = 0; i < counts.verdicts.size(); ++i)
    if (counts.verdicts[i] > 0)
      text << "; " << counts.verdicts[i] << " messages dropped: " << explain(static_cast<Verdict>(i));
  return text.str();
}

/// One file must not take the place of another, least of all of the recording.
void requireDifferent(const ReplayFiles& files) {
  const auto same = [](const std::string& a, const std::string& b) {
    std::error_code unreadable;
    return !a.empty() && (a == b || std::filesystem::equivalent(a, b, unreadable));
  };
  if (same(files.output, files.input) || same(files.tum, files.input) || same(files.tum, files.output))
    throw InputError("the input, --output and --tum must be different files");
}

}  // namespace

namespace {

/// Nobody asks a bag for relative motions.
Parameters withoutHistory(Parameters parameters) {
  parameters.relative_motion.history = Duration::zero();
  return parameters;
}

}  // namespace

void replay(const Parameters& parameters, const TopicNames& topics, const ReplayFiles& files) {
  requireDifferent(files);
  const std::unique_ptr<rosbag::Bag> bag = openBag(files.input);
  OdometryAdapter adapter(withoutHistory(parameters));
  const InputTopics inputs(parameters, adapter.pipeline().steeringNeeded(), topics);
  requireTopics(*bag, files.input, inputs.required());
  ReplayOutput output(files, parameters, adapter.frames());
  MessageFeed input(adapter, topics);

  rosbag::View view(*bag, inputs.query());
  Progress progress("replay", static_cast<double>(view.size()));
  double done = 0.0;
  for (const rosbag::MessageInstance& message : view) {
    writeComplete(adapter, message.getTime(), output);
    input.feed(message);
    writeComplete(adapter, message.getTime(), output);
    progress.update(++done);
  }
  // Nothing comes any more: what waits gives up at its deadline, as it would live.
  writeComplete(adapter, ros::TIME_MAX, output);
  if (output.updates() == 0)
    throw InputError(files.input + " gave no odometry" + reasons(adapter.pipeline().counts()));
  output.commit();
}

}  // namespace bs_car_odometry::tools
