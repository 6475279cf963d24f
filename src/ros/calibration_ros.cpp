#include "bs_car_odometry/ros/calibration_ros.hpp"

#include "bs_car_odometry/calibration/atomic_file.hpp"
#include "bs_car_odometry/calibration/checkpoint.hpp"
#include "bs_car_odometry/calibration/observability.hpp"
#include "bs_car_odometry/calibration/result_file.hpp"
#include "bs_car_odometry/ros/calibration_messages.hpp"
#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/odometry_ros.hpp"
#include "bs_car_odometry/ros/transform_reader.hpp"
#include "bs_car_odometry/ros/verdicts.hpp"

#include <algorithm>

namespace bs_car_odometry {

using calibration::CalibrationStage;
using calibration::CalibrationUpdate;
using calibration::LaserVerdict;

namespace {

// Every message counts: a bag that is played fast is caught up with, a flood is not hoarded.
constexpr std::uint32_t kQueueSize = 5000;
constexpr double kPathPeriod = 1.0;         // [s]
constexpr double kCutPeriod = 0.5;          // [s], until messages that were cut are counted
constexpr double kCheckpointPeriod = 10.0;  // [s]

}  // namespace

CalibrationRos::CalibrationRos(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : node_(node),
      private_node_(private_node),
      adapter_(loadNodeParameters(private_node)),
      reckoning_(adapter_.parameters()),
      paths_(adapter_.parameters()),
      diagnostics_(node, private_node, adapter_),
      clock_(adapter_.parameters().limits.max_future),
      wait_timer_(node, [this](const ros::Time& now) { takeAndWait(now); }) {
  state_.vehicle = adapter_.parameters().vehicle.name;
  state_.vehicle_checksum = calibration::vehicleChecksum(adapter_.parameters());
  adapter_.setListener([this](const CalibrationUpdate& update) { note(update); });
  resume();
  advertise();
  advertiseServices();
  subscribe();
}

// --- wiring ----------------------------------------------------------------------------------------------

void CalibrationRos::advertise() {
  state_publisher_ = node_.advertise<CalibrationState>("calibration", kQueueSize, true);
  odom_publisher_ = node_.advertise<nav_msgs::Odometry>("calibrated_odom", kQueueSize);
  laser_path_publisher_ = node_.advertise<nav_msgs::Path>("laser_path", 1, true);
  before_publisher_ = node_.advertise<nav_msgs::Path>("path_before", 1, true);
  after_publisher_ = node_.advertise<nav_msgs::Path>("path_after", 1, true);
  path_timer_ = node_.createWallTimer(ros::WallDuration(kPathPeriod),
                                      [this](const ros::WallTimerEvent&) { publishPaths(); });
  checkpoint_timer_ = node_.createWallTimer(ros::WallDuration(kCheckpointPeriod),
                                            [this](const ros::WallTimerEvent&) { keep(); });
  cut_timer_ = node_.createWallTimer(ros::WallDuration(kCutPeriod), [this](const ros::WallTimerEvent&) {
    for (const CheckedSubscriber& subscriber : subscribers_) subscriber.tellCut();
  });
}

void CalibrationRos::advertiseServices() {
  servers_ = {private_node_.advertiseService("start", &CalibrationRos::onStart, this),
              private_node_.advertiseService("reset", &CalibrationRos::onReset, this),
              private_node_.advertiseService("save", &CalibrationRos::onSave, this)};
}

template <typename Message, typename Callback>
void CalibrationRos::subscribeTo(const std::string& topic, const Callback& callback) {
  const auto take = [callback](const ros::MessageEvent<const Message>& event) {
    const Sender sender{event.getPublisherName(), toTime(event.getReceiptTime()).value_or(Time())};
    callback(event.getConstMessage().get(), sender);
  };
  subscribers_.push_back(CheckedSubscriber::make<Message>(node_, topic, kQueueSize, take,
                                                          [callback] { callback(nullptr, Sender()); }));
}

void CalibrationRos::subscribe() {
  subscribeTransforms();
  subscribeLaser();
  if (adapter_.parameters().input == InputSource::kJointStates) return subscribeJoints();
  for (const Axle axle : kAllAxles)
    if (adapter_.pipeline().steeringNeeded()[axle]) subscribeSteering(axle);
  subscribeWheels();
}

void CalibrationRos::subscribeSteering(Axle axle) {
  const char* topic = axle == Axle::kFront ? "front_steering" : "rear_steering";
  subscribeTo<SteeringAngle>(topic, [this, axle, topic](const SteeringAngle* message, const Sender& sender) {
    receive([&](const ros::Time& now) {
      warn(topic, message ? adapter_.add(axle, *message, now, sender) : adapter_.addCut());
    });
  });
}

void CalibrationRos::subscribeWheels() {
  subscribeTo<WheelTicks>("wheel_ticks", [this](const WheelTicks* message, const Sender& sender) {
    diagnostics_.noteWheels();
    receive([&](const ros::Time& now) {
      warn("wheel_ticks", message ? adapter_.add(*message, now, sender) : adapter_.addCut());
    });
  });
}

void CalibrationRos::subscribeJoints() {
  subscribeTo<RawJointState>("joint_states", [this](const RawJointState* message, const Sender& sender) {
    receive([&](const ros::Time& now) {
      if (!message) return warn("joint_states", adapter_.addCut());
      const JointVerdicts verdicts = adapter_.add(*message, now, sender);
      if (verdicts.wheels) diagnostics_.noteWheels();
      warn("joint_states", verdicts.worst());
    });
  });
}

void CalibrationRos::subscribeLaser() {
  using Pose = geometry_msgs::PoseWithCovarianceStamped;
  subscribeTo<Pose>("laser_pose", [this](const Pose* message, const Sender& /*sender*/) {
    diagnostics_.noteLaser();
    receive([&](const ros::Time& now) {
      warn(message ? adapter_.add(*message, now) : adapter_.addCutLaser(), now);
    });
  });
}

void CalibrationRos::subscribeTransforms() {
  if (adapter_.mountKnown()) return;
  for (const char* topic : {"/tf_static", "/tf"})
    subscribeTo<RawMessage<tf2_msgs::TFMessage>>(
        topic, [this](const RawMessage<tf2_msgs::TFMessage>* message, const Sender& /*sender*/) {
          if (!message || adapter_.mountKnown()) return;
          if (const auto transforms = readTransforms(ByteReader(message->bytes))) adapter_.add(*transforms);
          if (adapter_.mountKnown()) resume();
        });
}

// --- messages in -----------------------------------------------------------------------------------------

template <typename Add>
void CalibrationRos::receive(const Add& add) {
  const ros::Time now = ros::Time::now();
  if (!clock_.runs(now)) return;
  if (clock_.wentBack(now)) {
    adapter_.clockWentBack(ros::Time::isSimTime());
    if (ros::Time::isSimTime()) beginAnew();
  }
  // Wheels whose wait has ended come first.
  takeUpdates(now);
  add(now);
  takeAndWait(now);
}

void CalibrationRos::takeUpdates(const ros::Time& now) {
  while (const std::optional<OdometryUpdate> update = adapter_.next(now)) {
    reckoning_.add(*update);
    publishOdometry();
  }
  publishOdometry();
}

void CalibrationRos::takeAndWait(const ros::Time& now) {
  takeUpdates(now);
  wait_timer_.start(adapter_.deadline(), now);
}

void CalibrationRos::warn(const char* topic, Verdict verdict) {
  drop_log_.warn(topic, verdict, adapter_.pipeline().counts());
}

void CalibrationRos::warn(LaserVerdict verdict, const ros::Time& now) {
  if (verdict == LaserVerdict::kAccepted || !laser_log_[static_cast<std::size_t>(verdict)].isDue()) return;
  if (verdict == LaserVerdict::kNoMount) {
    ROS_WARN_STREAM(adapter_.waitingForMount(now));
  } else {
    ROS_WARN_STREAM("message on laser_pose dropped: " << explain(verdict));
  }
}

/// Called by the calibration after each laser pose that it took.
void CalibrationRos::note(const CalibrationUpdate& update) {
  if (reckoning_.correct(update)) {
    paths_.start();
    const Pose2& pose = update.estimate.pose;
    if (begin_log_.isDue())
      ROS_INFO("calibrated_odom begins where the laser sees the car (%.3f m, %.3f m, %.3f rad)", pose.x,
               pose.y, pose.yaw);
  }
  paths_.add(update);
  paths_changed_ = true;
  diagnostics_.note(update);
  if (update.jump && jump_log_.isDue()) ROS_WARN_STREAM(explain(*update.jump));
  publishState(toRos(update.stamp));
}

// --- messages out ----------------------------------------------------------------------------------------

/// Laser poses that never came to the calibration, which counts those that it drops itself.
std::uint64_t CalibrationRos::refusedAtTheDoor() const {
  const LaserInputCounts& counts = adapter_.laserCounts();
  std::uint64_t refused = 0;
  for (const LaserVerdict verdict :
       {LaserVerdict::kNotFinite, LaserVerdict::kBadCovariance, LaserVerdict::kStampZero,
        LaserVerdict::kStampInvalid, LaserVerdict::kFuture, LaserVerdict::kOtherFrame,
        LaserVerdict::kNoMount})
    refused += counts[verdict];
  return refused;
}

void CalibrationRos::publishState(const ros::Time& stamp) {
  state_.header.stamp = stamp;
  state_.header.frame_id = adapter_.mapFrame();
  fillCalibrationState(adapter_.calibrator(), adapter_.parameters().calibration.method, state_);
  state_.dropped += refusedAtTheDoor() - refused_before_;
  state_publisher_.publish(state_);
}

void CalibrationRos::publishOdometry() {
  while (const std::optional<calibration::DeadReckonedPose> pose = reckoning_.next()) {
    paths_.add(pose->step);
    const auto message = boost::make_shared<nav_msgs::Odometry>();
    fillOdometry(*pose, adapter_.mapFrame(), adapter_.parameters().base_frame,
                 adapter_.parameters().unmeasured_variance, *message);
    odom_publisher_.publish(message);
  }
}

void CalibrationRos::publishPaths() {
  if (!paths_changed_) return;
  paths_changed_ = false;
  const auto publish = [this](const ros::Publisher& publisher, const auto& poses) {
    if (publisher.getNumSubscribers() > 0) publisher.publish(toPath(poses(), state_.header));
  };
  publish(laser_path_publisher_, [this] { return paths_.laserPath(); });
  publish(before_publisher_, [this] { return paths_.path(paths_.configured()); });
  publish(after_publisher_, [this] { return paths_.path(adapter_.calibrator().estimate().values); });
}

// --- what is kept ----------------------------------------------------------------------------------------

/// A calibration that was ended in the middle goes on; and it is known early whether its end can be saved.
void CalibrationRos::resume() {
  const std::string& output = adapter_.parameters().output;
  if (output.empty() || !adapter_.mountKnown()) return;
  try {
    calibration::checkWritable(output);
    const auto memory = calibration::readCheckpoint(calibration::checkpointPath(output),
                                                    adapter_.parameters(), ros::WallTime::now().toSec());
    if (memory && adapter_.resume(*memory))
      ROS_WARN("going on with the calibration that ended %.1f m after its start; call ~start to begin anew",
               memory->driven.distance);
  } catch (const std::exception& error) {
    ROS_WARN_STREAM(error.what());
    diagnostics_.noteOutput(error.what());
  }
}

void CalibrationRos::keep() {
  const std::string& output = adapter_.parameters().output;
  if (output.empty()) return;
  try {
    if (const auto memory = adapter_.calibrator().memory())
      calibration::writeCheckpoint(calibration::checkpointPath(output), *memory, adapter_.parameters(),
                                   ros::WallTime::now().toSec());
    diagnostics_.noteOutput({});
  } catch (const std::exception& error) {
    diagnostics_.noteOutput(error.what());
  }
}

void CalibrationRos::end() {
  const std::string& output = adapter_.parameters().output;
  if (!output.empty()) calibration::removeCheckpoint(calibration::checkpointPath(output));
}

/// After the calibration was told to.
void CalibrationRos::beginAnew() {
  end();
  reckoning_.start();
  paths_.start();
  diagnostics_.noteStart();
  refused_before_ = refusedAtTheDoor();
  publishState(ros::Time::now());
}

bool CalibrationRos::onStart(std_srvs::Trigger::Request& /*request*/, std_srvs::Trigger::Response& response) {
  adapter_.start();
  beginAnew();
  response.success = true;
  response.message = "the calibration begins anew";
  return true;
}

bool CalibrationRos::onReset(std_srvs::Trigger::Request& /*request*/, std_srvs::Trigger::Response& response) {
  adapter_.clockWentBack(true);
  beginAnew();
  response.success = true;
  response.message = "everything is as at the start: inputs and calibration";
  return true;
}

/// Empty when nothing speaks against it.
std::string CalibrationRos::whyNotSaved() const {
  const calibration::Calibrator& calibrator = adapter_.calibrator();
  const calibration::ParameterMask observed = calibrator.observed();
  if (adapter_.parameters().output.empty()) return "no file to write: set the parameter 'output'";
  if (calibrator.stage() == CalibrationStage::kStart)
    return "nothing is known yet: no laser poses that agree with each other have come since the start";
  std::string implausible = calibration::implausibleGains(calibrator.estimate().values, observed);
  if (!implausible.empty()) return implausible;
  const bool none = std::none_of(observed.begin(), observed.end(), [](bool one) { return one; });
  if (adapter_.parameters().calibration.allow_partial && !none) return {};
  return whyNotAllObserved(knowledgeOf(calibrator));
}

bool CalibrationRos::onSave(std_srvs::Trigger::Request& /*request*/, std_srvs::Trigger::Response& response) {
  const std::string& output = adapter_.parameters().output;
  response.message = whyNotSaved();
  response.success = response.message.empty();
  if (!response.success) return true;
  try {
    calibration::writeCalibrationFile(output, resultOf(adapter_.calibrator()), adapter_.parameters());
    const std::string missing = calibration::missing(knowledgeOf(adapter_.calibrator()));
    response.message = "saved to " + output + (missing.empty() ? "" : "; left out: " + missing);
    ROS_INFO_STREAM(response.message);
  } catch (const std::exception& error) {
    response.success = false;
    response.message = error.what();
  }
  return true;
}

}  // namespace bs_car_odometry
