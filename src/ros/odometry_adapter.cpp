#include "bs_car_odometry/ros/odometry_adapter.hpp"

#include <cmath>

namespace bs_car_odometry {

OdometryAdapter::OdometryAdapter(const Parameters& parameters)
    : parameters_(parameters),
      frames_{parameters.odom_frame, parameters.base_frame, parameters.unmeasured_variance},
      pipeline_(toConfiguration(parameters)),
      acceptance_(parameters) {}

std::optional<Time> OdometryAdapter::stampOf(const ros::Time& stamp, const ros::Time& receipt) const {
  return toTime(parameters_.stamp_source == StampSource::kReceipt ? receipt : stamp);
}

Verdict OdometryAdapter::add(const WheelTicks& message, const ros::Time& receipt, const Sender& sender) {
  if (wheel_publishers_.isRival(sender)) return pipeline_.reject(Verdict::kRivalPublisher);
  const std::optional<Time> stamp = stampOf(message.header.stamp, receipt);
  if (!stamp) return pipeline_.reject(Verdict::kStampInvalid);
  return addWheels({*stamp,
                    toTime(receipt).value_or(Time()),
                    {{message.front_left, message.front_right, message.rear_left, message.rear_right}}},
                   sender);
}

Verdict OdometryAdapter::add(Axle axle, const SteeringAngle& message, const ros::Time& receipt,
                             const Sender& sender) {
  if (steering_publishers_[axle].isRival(sender)) return pipeline_.reject(Verdict::kRivalPublisher);
  const std::optional<Time> stamp = stampOf(message.header.stamp, receipt);
  if (!stamp) return pipeline_.reject(Verdict::kStampInvalid);
  return addSteering(axle, *stamp, toTime(receipt).value_or(Time()), message.angle, sender);
}

JointVerdicts OdometryAdapter::add(const RawJointState& message, const ros::Time& receipt,
                                   const Sender& sender) {
  const std::optional<JointPositions> joints = readJointState(message);
  if (!joints) return {pipeline_.reject(Verdict::kNotFinite), std::nullopt};
  const std::optional<Time> stamp = stampOf(joints->stamp, receipt);
  if (!stamp) return {pipeline_.reject(Verdict::kStampInvalid), std::nullopt};
  const Time received = toTime(receipt).value_or(Time());
  const Verdict steering = addSteeringJoints(*joints, *stamp, received, sender);
  return {steering, addWheelJoints(*joints, *stamp, received, sender)};
}

/// Only what is taken makes its sender the one that is heard.
Verdict OdometryAdapter::addWheels(const WheelCounts& counts, const Sender& sender) {
  const Verdict verdict = pipeline_.addWheels(counts);
  if (verdict == Verdict::kAccepted) wheel_publishers_.hear(sender);
  return verdict;
}

Verdict OdometryAdapter::addSteering(Axle axle, Time stamp, Time receipt, double reading,
                                     const Sender& sender) {
  const Verdict verdict = pipeline_.addSteering(axle, stamp, receipt, reading);
  if (verdict == Verdict::kAccepted) steering_publishers_[axle].hear(sender);
  return verdict;
}

/// @return the first refusal
Verdict OdometryAdapter::addSteeringJoints(const JointPositions& joints, Time stamp, Time receipt,
                                           const Sender& sender) {
  const PerAxle<std::optional<double>> readings =
      axleReadings(parameters_.vehicle, parameters_.joints, joints);
  Verdict refusal = Verdict::kAccepted;
  for (const Axle axle : kAllAxles) {
    if (!readings[axle] || !pipeline_.steeringNeeded()[axle]) continue;
    const Verdict verdict = steering_publishers_[axle].isRival(sender)
                                ? pipeline_.reject(Verdict::kRivalPublisher)
                                : addSteering(axle, stamp, receipt, *readings[axle], sender);
    if (refusal == Verdict::kAccepted) refusal = verdict;
  }
  return refusal;
}

/// None for a message that lacks a wheel: it is another driver's, for the steering or for other joints.
std::optional<Verdict> OdometryAdapter::addWheelJoints(const JointPositions& joints, Time stamp, Time receipt,
                                                       const Sender& sender) {
  WheelCounts counts{stamp, receipt, {}};
  for (const Wheel wheel : kAllWheels) {
    if (!pipeline_.wheelUsed()[wheel]) continue;
    const std::optional<double> position = joints[parameters_.joints.wheels[wheel]];
    if (!position) return std::nullopt;
    if (!(std::abs(*position) < kFarthestJoint)) return pipeline_.reject(Verdict::kNotFinite);
    counts.ticks[wheel] = std::llround(*position * kTicksPerRadian);
  }
  if (wheel_publishers_.isRival(sender)) return pipeline_.reject(Verdict::kRivalPublisher);
  return addWheels(counts, sender);
}

std::optional<OdometryUpdate> OdometryAdapter::next(const ros::Time& now) {
  const std::optional<Time> time = toTime(now);
  return time ? pipeline_.next(*time) : std::nullopt;
}

std::optional<ros::Time> OdometryAdapter::deadline() const {
  const std::optional<Time> deadline = pipeline_.deadline();
  if (!deadline) return std::nullopt;
  return toRos(*deadline);
}

std::string OdometryAdapter::setPose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  const std::string& frame = message.header.frame_id;
  if (!frame.empty() && frame != frames_.odom && frame != "/" + frames_.odom)
    return "its frame is '" + frame.substr(0, 64) + "': set_pose takes poses in '" + frames_.odom + "'";
  const std::optional<Pose2> pose = toPose(message.pose.pose);
  if (!pose) return "its pose is not finite, or its quaternion is none";
  const Eigen::Matrix3d covariance = toPlanarCovariance(message.pose.covariance);
  if (!isCovariance(covariance)) return "its covariance is not finite, or not positive semidefinite";
  pipeline_.setPose(*pose, covariance);
  return {};
}

std::string OdometryAdapter::add(const CalibrationState& message) {
  const CalibrationAcceptance::Answer answer = acceptance_.take(message, pipeline_.calibration());
  if (answer.calibration) pipeline_.setCalibration(*answer.calibration);
  return answer.refused;
}

void OdometryAdapter::clockWentBack(bool simulated_time) {
  if (simulated_time) {
    pipeline_.restart();
  } else {
    pipeline_.rebaseTime();
  }
}

}  // namespace bs_car_odometry
