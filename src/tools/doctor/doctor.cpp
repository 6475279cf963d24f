#include "doctor.hpp"

#include "../bag_input.hpp"
#include "../calibrate.hpp"
#include "checks.hpp"
#include "collect.hpp"
#include "topic_check.hpp"

#include "bs_car_odometry/ros/calibration_adapter.hpp"

#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <map>
#include <optional>
#include <ostream>

namespace bs_car_odometry::tools::doctor {

namespace {

/// Goes through a bag once: statistics of every topic, and the calibration itself.
class Pass {
 public:
  Pass(const Parameters& parameters, const TopicNames& names)
      : names_(names), collector_(parameters), calibration_(quick(parameters)) {}

  void run(const rosbag::Bag& bag) {
    rosbag::View view(bag, rosbag::TopicQuery(topics()));
    Progress progress("bag_doctor", static_cast<double>(view.size()));
    double done = 0.0;
    readMessages(bag.getFileName(), [&] {
      for (const rosbag::MessageInstance& message : view) {
        take(message);
        while (calibration_.next(message.getTime())) {
        }
        progress.update(++done);
      }
    });
    while (calibration_.next(ros::TIME_MAX)) {
    }
    calibration_.finish();
    if (calibration_.mountKnown()) collector_.setMount(calibration_.parameters().laser);
  }

  const DriveRecord& record() const { return collector_.record(); }
  const CalibrationAdapter& calibration() const { return calibration_; }

 private:
  /// Nobody asks for relative motions, and the filter needs no covariance of the pose.
  static Parameters quick(Parameters parameters) {
    parameters.relative_motion.history = Duration::zero();
    return parameters;
  }

  std::vector<std::string> topics() const {
    std::vector<std::string> topics{"/tf", "tf", "/tf_static", "tf_static"};
    for (const NeededTopic& needed : neededTopics(record().parameters))
      for (const std::string& spelling : names_.spellings(needed.name)) topics.push_back(spelling);
    return topics;
  }

  /// Messages of another type than the topic should have are none.
  void take(const rosbag::MessageInstance& message) {
    const std::string& topic = message.getTopic();
    if (names_.matches(topic, "wheel_ticks")) return give<WheelTicks>(message);
    if (names_.matches(topic, "joint_states")) return give<RawJointState>(message);
    if (names_.matches(topic, "laser_pose")) return give<geometry_msgs::PoseWithCovarianceStamped>(message);
    for (const Axle axle : kAllAxles)
      if (names_.matches(topic, std::string(name(axle)) + "_steering")) return giveAngle(axle, message);
    if (const auto tf = message.instantiate<tf2_msgs::TFMessage>()) calibration_.add(*tf);
  }

  template <typename Message>
  void give(const rosbag::MessageInstance& instance) {
    const auto message = instance.instantiate<Message>();
    if (!message) return;
    collector_.add(*message, instance.getTime());
    calibration_.add(*message, instance.getTime());
  }

  void giveAngle(Axle axle, const rosbag::MessageInstance& instance) {
    const auto message = instance.instantiate<SteeringAngle>();
    if (!message) return;
    collector_.add(axle, *message, instance.getTime());
    calibration_.add(axle, *message, instance.getTime());
  }

  const TopicNames& names_;
  Collector collector_;
  CalibrationAdapter calibration_;
};

Finding mountMissing(const Parameters& parameters) {
  return error("laser/frame is '" + parameters.laser.frame + "', and no tf in the bag connects it with '" +
                   parameters.base_frame + "'",
               "record /tf_static and /tf, or give laser/x, laser/y and laser/yaw with an empty laser/frame");
}

/// What needs the laser and the car in one frame.
Findings checkMotion(const DriveRecord& record) {
  const std::optional<LaserLag> lag = estimateLaserLag(record);
  Findings findings = checkLag(record, lag);
  const std::vector<MotionWindow> by_laser =
      record.mount_known ? windowsByLaser(record, lag ? lag->lag : record.parameters.laser.time_offset)
                         : std::vector<MotionWindow>();
  const Findings yaw = checkLaserYaw(record, by_laser);
  append(yaw, findings);
  // Seen from a body that is turned, every wheel would look wrong.
  const bool turned = !yaw.empty() && yaw.front().severity == Severity::kError;
  if (turned || by_laser.empty()) {
    append(checkSteering(record, {}), findings);
    append(checkWheels(record, windowsBySteering(record), "steering angle"), findings);
    return findings;
  }
  append(checkSteering(record, by_laser), findings);
  append(checkWheels(record, by_laser, "laser"), findings);
  return findings;
}

Findings checkRecord(const DriveRecord& record) {
  Findings findings = checkClocks(record);
  append(checkCounters(record), findings);
  append(checkLaser(record), findings);
  if (!record.mount_known) findings.push_back(mountMissing(record.parameters));
  append(checkMotion(record), findings);
  return findings;
}

}  // namespace

int Examination::exitStatus() const {
  const bool has_error = std::any_of(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.severity == Severity::kError;
  });
  if (has_error) return kInputErrorStatus;
  return all_gains_observed ? 0 : kNotObservedStatus;
}

Examination examine(const std::string& path, const Parameters& parameters, const TopicNames& names) {
  const std::unique_ptr<rosbag::Bag> bag = openBag(path);
  const std::map<std::string, std::string> types = typesByTopic(*bag);
  if (types.empty()) throw InputError(path + " holds no messages");
  Examination examination;
  examination.missing_topics = checkTopics(types, neededTopics(parameters), names);
  Pass pass(parameters, names);
  pass.run(*bag);
  Findings& findings = examination.findings;
  findings = examination.missing_topics;
  append(checkRecord(pass.record()), findings);
  if (!examination.missing_topics.empty()) return examination;
  append(checkExcitation(pass.calibration()), findings);
  examination.all_gains_observed = pass.calibration().calibrator().allGainsObserved();
  return examination;
}

int diagnose(const std::string& bag, const Parameters& parameters, const TopicNames& names,
             std::ostream& out) {
  const Examination examination = examine(bag, parameters, names);
  print(examination.findings, out);
  out << std::flush;
  std::string missing;
  for (const Finding& finding : examination.missing_topics)
    missing += (missing.empty() ? "" : "; ") + finding.text + ": " + finding.remedy;
  if (!missing.empty()) throw InputError(bag + ": " + missing);
  return examination.exitStatus();
}

}  // namespace bs_car_odometry::tools::doctor
