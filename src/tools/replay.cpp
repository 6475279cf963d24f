#include "replay.hpp"

#include "bag_messages.hpp"
#include "bag_writer.hpp"
#include "input_topics.hpp"
#include "tum_writer.hpp"

#include "bs_car_odometry/OdometryStatus.h"
#include "bs_car_odometry/calibration/atomic_file.hpp"
#include "bs_car_odometry/ros/odometry_adapter.hpp"

#include <nav_msgs/Odometry.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <filesystem>
#include <optional>
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
  std::optional<calibration::AtomicFile> tum_file_;  // outlives what writes it
  std::optional<TumWriter> tum_;
  nav_msgs::Odometry odom_;
  tf2_msgs::TFMessage transforms_;
  OdometryStatus status_;
  std::size_t updates_{0};
};

/// Gives a recorded message to the adapter: an input, or a pose that was set or a calibration that was
/// accepted during the drive.
void give(const BagMessage& message, OdometryAdapter& adapter) {
  if (giveInput(message, adapter)) return;
  if (const auto* pose = std::get_if<geometry_msgs::PoseWithCovarianceStampedConstPtr>(&message.content)) {
    const std::string refused = adapter.setPose(**pose);
    if (!refused.empty()) warn("set_pose refused: " + refused);
  } else if (const auto* calibration = std::get_if<CalibrationStateConstPtr>(&message.content)) {
    const std::string refused = adapter.add(**calibration);
    if (!refused.empty()) warn("message on calibration refused: " + refused);
  }
}

/// What is required, and what else the drive may hold for the odometry.
rosbag::TopicQuery query(const InputTopics& inputs, const TopicNames& topics, bool accept_calibration) {
  std::vector<std::string> spellings = inputs.spellings();
  for (const std::string& name : topics.spellings("set_pose")) spellings.push_back(name);
  for (const std::string& name : topics.spellings("calibration"))
    if (accept_calibration) spellings.push_back(name);
  return rosbag::TopicQuery(spellings);
}

void writeComplete(OdometryAdapter& adapter, const ros::Time& now, ReplayOutput& output) {
  while (const std::optional<OdometryUpdate> update = adapter.next(now)) output.write(*update);
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
  const InputTopics inputs(parameters, topics);
  requireTopics(*bag, files.input, inputs.required());
  ReplayOutput output(files, parameters, adapter.frames());

  rosbag::View view(*bag, query(inputs, topics, parameters.accept_calibration));
  Progress progress("replay", static_cast<double>(view.size()));
  double done = 0.0;
  readMessages(files.input, [&] {
    BagMessages messages(view, topics);
    while (const BagMessage* message = messages.next()) {
      writeComplete(adapter, message->receipt, output);
      give(*message, adapter);
      writeComplete(adapter, message->receipt, output);
      progress.update(++done);
    }
  });
  // Nothing comes any more: what waits gives up at its deadline, as it would live.
  writeComplete(adapter, ros::TIME_MAX, output);
  if (output.updates() == 0)
    throw InputError(files.input + " gave no odometry" + reasons(adapter.pipeline().counts()));
  output.commit();
}

}  // namespace bs_car_odometry::tools
