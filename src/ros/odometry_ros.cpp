#include "bs_car_odometry/ros/odometry_ros.hpp"

#include "bs_car_odometry/calibration/result_file.hpp"
#include "bs_car_odometry/parameters/load.hpp"
#include "bs_car_odometry/ros/parameter_server.hpp"
#include "bs_car_odometry/ros/relative_motion.hpp"
#include "bs_car_odometry/ros/verdicts.hpp"

#include <geometry_msgs/PoseArray.h>
#include <nav_msgs/Odometry.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>

namespace bs_car_odometry {

namespace {

constexpr std::uint32_t kQueueSize = 200;  // bounded: a slow moment is caught up, a flood is not hoarded
constexpr double kLogPeriod = 5.0;         // [s] between warnings of one cause
constexpr double kParticlePeriod = 0.1;    // [s] of wall time, enough for the eye
constexpr double kLongestWait = 1e6;       // [s], within what a timer takes

}  // namespace

Parameters loadNodeParameters(const ros::NodeHandle& private_node) {
  LoadedParameters loaded = loadParameters(parameterServerTree(private_node));
  for (const std::string& warning : loaded.warnings) ROS_WARN_STREAM(warning);
  return std::move(loaded.parameters);
}

OdometryRos::OdometryRos(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : node_(node),
      private_node_(private_node),
      parameters_(loadNodeParameters(private_node)),
      calibration_error_(calibration::applyCalibrationFile(parameters_)),
      adapter_(parameters_),
      diagnostics_(node, private_node, adapter_.pipeline(), parameters_.vehicle.name) {
  reportCalibrationFile();
  advertise();
  subscribe();
}

void OdometryRos::reportCalibrationFile() {
  using Level = diagnostic_msgs::DiagnosticStatus;
  if (!calibration_error_.empty()) {
    const std::string text = "the gains are those of the vehicle file: " + calibration_error_;
    ROS_ERROR_STREAM(text);
    diagnostics_.setCalibration(Level::ERROR, text);
  } else if (!parameters_.calibration_file.empty()) {
    ROS_INFO_STREAM("the gains are those of " << parameters_.calibration_file);
    diagnostics_.setCalibration(Level::OK, "the gains are those of " + parameters_.calibration_file);
  }
}

void OdometryRos::advertise() {
  odom_publisher_ = node_.advertise<nav_msgs::Odometry>("odom", kQueueSize);
  status_publisher_ = node_.advertise<OdometryStatus>("odometry_status", kQueueSize);
  if (parameters_.publish_tf) tf_publisher_ = node_.advertise<tf2_msgs::TFMessage>("/tf", kQueueSize);
  if (parameters_.odometry.uncertainty == Uncertainty::kMonteCarlo)
    particles_publisher_ = node_.advertise<geometry_msgs::PoseArray>("particles", 1);
  reset_server_ = private_node_.advertiseService("reset", &OdometryRos::onReset, this);
  relative_motion_server_ =
      private_node_.advertiseService("relative_motion", &OdometryRos::onRelativeMotion, this);
  // Idle until startWaiting() sets its period.
  wait_timer_ = node_.createTimer(
      ros::Duration(kLongestWait), [this](const ros::TimerEvent&) { publishUpdates(ros::Time::now()); }, true,
      false);
}

void OdometryRos::subscribe() {
  subscribers_.push_back(node_.subscribe("set_pose", kQueueSize, &OdometryRos::onSetPose, this));
  if (parameters_.accept_calibration)
    subscribers_.push_back(node_.subscribe("calibration", kQueueSize, &OdometryRos::onCalibration, this));
  if (parameters_.input == InputSource::kJointStates) return subscribeJoints();
  for (const Axle axle : kAllAxles)
    if (adapter_.pipeline().steeringNeeded()[axle]) subscribeSteering(axle);
  subscribeWheels();
}

void OdometryRos::subscribeSteering(Axle axle) {
  const char* topic = axle == Axle::kFront ? "front_steering" : "rear_steering";
  const boost::function<void(const SteeringAngle&)> callback = [this, axle,
                                                                topic](const SteeringAngle& message) {
    receive(topic, [&](const ros::Time& now) { return adapter_.add(axle, message, now); });
  };
  subscribers_.push_back(node_.subscribe<const SteeringAngle&>(topic, kQueueSize, callback, {},
                                                               ros::TransportHints().tcpNoDelay()));
}

void OdometryRos::subscribeWheels() {
  const boost::function<void(const WheelTicks&)> callback = [this](const WheelTicks& message) {
    receive("wheel_ticks", [&](const ros::Time& now) { return adapter_.add(message, now); });
    diagnostics_.noteWheels();
  };
  subscribers_.push_back(node_.subscribe<const WheelTicks&>("wheel_ticks", kQueueSize, callback, {},
                                                            ros::TransportHints().tcpNoDelay()));
}

void OdometryRos::subscribeJoints() {
  const boost::function<void(const RawJointState&)> callback = [this](const RawJointState& message) {
    receive("joint_states", [&](const ros::Time& now) {
      const JointVerdicts verdicts = adapter_.add(message, now);
      if (verdicts.wheels) diagnostics_.noteWheels();
      return verdicts.worst();
    });
  };
  subscribers_.push_back(node_.subscribe<const RawJointState&>("joint_states", kQueueSize, callback, {},
                                                               ros::TransportHints().tcpNoDelay()));
}

template <typename Add>
void OdometryRos::receive(const char* topic, const Add& add) {
  const ros::Time now = ros::Time::now();
  if (now.isZero()) {
    if (!warned_of_clock_) ROS_WARN("waiting for /clock: use_sim_time is set, and nothing publishes it");
    warned_of_clock_ = true;
    return;
  }
  noteClock(now);
  // Wheels whose wait has ended come first. Between a tick and its odometry stands only what that needs.
  if (adapter_.deadline()) publishComplete(now);
  const Verdict verdict = add(now);
  publishComplete(now);
  if (verdict != Verdict::kAccepted) warn(topic, verdict);
  warnOfLateDrops();
  startWaiting(now);
}

void OdometryRos::warn(const char* topic, Verdict verdict) {
  ros::SteadyTime& warned = warned_[static_cast<std::size_t>(verdict)];
  const ros::SteadyTime now = ros::SteadyTime::now();
  if (!warned.isZero() && (now - warned).toSec() < kLogPeriod) return;
  warned = now;
  ROS_WARN_STREAM("message on " << topic << " dropped: " << explain(verdict, adapter_.pipeline().counts()));
}

void OdometryRos::warnOfLateDrops() {
  const InputCounts& counts = adapter_.pipeline().counts();
  for (const Verdict verdict : {Verdict::kNoSteering, Verdict::kImplausible})
    if (counts[verdict] > known_counts_[verdict]) warn("wheel_ticks", verdict);
  if (counts.counter_restarts > known_counts_.counter_restarts)
    ROS_WARN("the wheel counters jumped and were taken as a new reference: was the driver restarted?");
  known_counts_ = counts;
}

/// A step back by less than max_future is harmless: stamps may be that far ahead anyway. Differences in 64
/// bits, since those of ros::Time throw beyond 68 years, which a clock that somebody else publishes may jump.
void OdometryRos::noteClock(const ros::Time& now) {
  const Time time = toTime(now).value_or(newest_receipt_);
  const Duration step_back = newest_receipt_ - time;
  const bool went_back = step_back > parameters_.limits.max_future;
  if (went_back) {
    ROS_WARN("the clock went back by %.3f s: %s", toSeconds(step_back),
             ros::Time::isSimTime() ? "a new run begins" : "the pose is kept");
    adapter_.clockWentBack(ros::Time::isSimTime());
  }
  if (went_back || newest_receipt_ < time) newest_receipt_ = time;
}

void OdometryRos::publishComplete(const ros::Time& now) {
  while (const std::optional<OdometryUpdate> update = adapter_.next(now)) publish(*update);
}

void OdometryRos::publishUpdates(const ros::Time& now) {
  publishComplete(now);
  warnOfLateDrops();
  startWaiting(now);
}

/// Wheels that wait for steering must be looked at again when their wait ends, even if nothing comes.
void OdometryRos::startWaiting(const ros::Time& now) {
  const std::optional<ros::Time> deadline = adapter_.deadline();
  if (!deadline) return;
  const double wait = *deadline > now ? deadline->toSec() - now.toSec() : 0.0;
  wait_timer_.stop();
  wait_timer_.setPeriod(ros::Duration(std::clamp(wait, 1e-4, kLongestWait)));
  wait_timer_.start();
}

void OdometryRos::publish(const OdometryUpdate& update) {
  const auto odom = boost::make_shared<nav_msgs::Odometry>();
  fillOdometry(update, adapter_.frames(), *odom);
  odom_publisher_.publish(odom);
  if (parameters_.publish_tf) {
    const auto transforms = boost::make_shared<tf2_msgs::TFMessage>();
    transforms->transforms.resize(1);
    fillTransform(update, adapter_.frames(), transforms->transforms.front());
    tf_publisher_.publish(transforms);
  }
  const auto status = boost::make_shared<OdometryStatus>();
  fillStatus(update, adapter_.frames(), *status);
  status_publisher_.publish(status);
  if (particles_publisher_) publishParticles(update);
  diagnostics_.noteUpdate(update);
}

void OdometryRos::publishParticles(const OdometryUpdate& update) {
  const ros::SteadyTime now = ros::SteadyTime::now();
  if (particles_publisher_.getNumSubscribers() == 0) return;
  if (!particles_published_.isZero() && (now - particles_published_).toSec() < kParticlePeriod) return;
  particles_published_ = now;
  const auto particles = boost::make_shared<geometry_msgs::PoseArray>();
  fillParticles(update, adapter_.pipeline().uncertainty(), adapter_.frames(),
                static_cast<std::size_t>(parameters_.odometry.particles.published), *particles);
  particles_publisher_.publish(particles);
}

void OdometryRos::onSetPose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  publishUpdates(ros::Time::now());
  const std::string refused = adapter_.setPose(message);
  if (refused.empty()) {
    ROS_INFO("the pose was set");
  } else {
    ROS_WARN_STREAM_THROTTLE(kLogPeriod, "set_pose refused: " << refused);
  }
}

void OdometryRos::onCalibration(const CalibrationState& message) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  publishUpdates(ros::Time::now());
  const std::uint64_t before = adapter_.acceptance().taken();
  const std::string refused = adapter_.add(message);
  if (!refused.empty()) {
    ROS_WARN_STREAM_THROTTLE(kLogPeriod, "message on calibration refused: " << refused);
    diagnostics_.setCalibration(Level::WARN, "message on calibration refused: " + refused);
    return;
  }
  const std::uint64_t taken = adapter_.acceptance().taken();
  if (taken == 0) return;
  if (before == 0) ROS_INFO("the calibration that runs is applied from now on");
  diagnostics_.setCalibration(Level::OK, "the gains are those of the calibration that runs");
}

bool OdometryRos::onRelativeMotion(RelativeMotion::Request& request, RelativeMotion::Response& response) {
  publishUpdates(ros::Time::now());
  fillRelativeMotion(adapter_.pipeline().motionHistory(), adapter_.frames().unmeasured_variance, request,
                     response);
  return true;
}

bool OdometryRos::onReset(std_srvs::Trigger::Request& /*request*/, std_srvs::Trigger::Response& response) {
  adapter_.reset();
  response.success = true;
  response.message = "back to the initial pose";
  return true;
}

}  // namespace bs_car_odometry
