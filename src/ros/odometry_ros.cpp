#include "bs_car_odometry/ros/odometry_ros.hpp"

#include "bs_car_odometry/calibration/result_file.hpp"
#include "bs_car_odometry/parameters/load.hpp"
#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/fault_sentences.hpp"
#include "bs_car_odometry/ros/parameter_server.hpp"
#include "bs_car_odometry/ros/relative_motion.hpp"
#include "bs_car_odometry/ros/transform_reader.hpp"
#include "bs_car_odometry/ros/verdicts.hpp"

#include <geometry_msgs/PoseArray.h>
#include <nav_msgs/Odometry.h>
#include <tf2_msgs/TFMessage.h>

namespace bs_car_odometry {

namespace {

constexpr std::uint32_t kQueueSize = 200;  // bounded: a slow moment is caught up, a flood is not hoarded
constexpr double kWatchPeriod = 0.5;       // [s] of wall time, for what is only reported
constexpr double kParticlePeriod = 0.1;    // [s] of wall time, enough for the eye

/// Why set_pose and calibration refuse a message that is none.
constexpr const char* kCut = "it is shorter than its lengths claim";

template <typename Message>
const ros::Time& stampOf(const Message& message) {
  return message.header.stamp;
}

/// Zero where the message has none.
ros::Time stampOf(const RawJointState& message) {
  ByteReader reader(message.bytes);
  reader.value<std::uint32_t>();  // header.seq
  ros::Time stamp;
  stamp.sec = reader.value<std::uint32_t>();
  stamp.nsec = reader.value<std::uint32_t>();
  return stamp;
}

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
      diagnostics_(node, private_node, adapter_.pipeline(), parameters_.vehicle.name),
      clock_(parameters_.limits.max_future),
      wait_timer_(node, [this](const ros::Time& now) { publishUpdates(now); }),
      early_(node, [this] {
        followClock(ros::Time::now());
        early_.deliverLate();
      }) {
  const InitialPose& initial = parameters_.initial_pose;
  ROS_INFO("a new run begins at the initial pose (%.3f m, %.3f m, %.3f rad)", initial.x, initial.y,
           initial.yaw);
  if (parameters_.odometry.axles != AxleSelection::kBoth)
    ROS_INFO(
        "one axle alone leaves nothing over: a faulty wheel or angle cannot be detected; "
        "'odometry/axles: both' can");
  reportCalibrationFile();
  advertise();
  subscribe();
}

/// Callbacks run in another thread, in a nodelet's manager: none may be under way when what it uses goes.
OdometryRos::~OdometryRos() {
  watch_timer_.stop();
  subscribers_.clear();
  transforms_subscriber_.shutdown();
  reset_server_.shutdown();
  relative_motion_server_.shutdown();
  wait_timer_.stop();
  early_.stop();
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
}

void OdometryRos::subscribe() {
  watch_timer_ = node_.createWallTimer(ros::WallDuration(kWatchPeriod), [this](const ros::WallTimerEvent&) {
    for (const CheckedSubscriber& subscriber : subscribers_) subscriber.tellCut();
    transforms_queue_.callAvailable();
  });
  if (parameters_.publish_tf) subscribeTransforms();
  using Pose = geometry_msgs::PoseWithCovarianceStamped;
  subscribeTo<Pose>("set_pose", [this](const Pose* message) { onSetPose(message); });
  if (parameters_.accept_calibration)
    subscribeTo<CalibrationState>("calibration",
                                  [this](const CalibrationState* message) { onCalibration(message); });
  if (parameters_.input == InputSource::kJointStates) return subscribeJoints();
  for (const Axle axle : kAllAxles)
    if (adapter_.pipeline().steeringNeeded()[axle]) subscribeSteering(axle);
  subscribeWheels();
}

template <typename Message, typename Add>
void OdometryRos::subscribeToSensor(const char* topic, const Add& add) {
  using Event = ros::MessageEvent<const Message>;
  const auto take = [this, topic, add](const Event& event) {
    const Sender sender{event.getPublisherName(), toTime(event.getReceiptTime()).value_or(Time())};
    receive(topic, [&](const ros::Time& now) { return add(event.getConstMessage().get(), now, sender); });
  };
  const auto callback = [this, take](const Event& event) {
    if (isEarly(stampOf(*event.getConstMessage())) && early_.keep([take, event] { take(event); })) return;
    take(event);
  };
  const auto on_cut = [this, topic, add] {
    receive(topic, [&](const ros::Time& now) { return add(nullptr, now, Sender()); });
  };
  subscribers_.push_back(CheckedSubscriber::make<Message>(node_, topic, kQueueSize, callback, on_cut));
}

template <typename Message, typename Take>
void OdometryRos::subscribeTo(const char* topic, const Take& take) {
  const auto callback = [take](const ros::MessageEvent<const Message>& event) {
    take(event.getConstMessage().get());
  };
  subscribers_.push_back(
      CheckedSubscriber::make<Message>(node_, topic, kQueueSize, callback, [take] { take(nullptr); }));
}

void OdometryRos::subscribeSteering(Axle axle) {
  const char* topic = axle == Axle::kFront ? "front_steering" : "rear_steering";
  subscribeToSensor<SteeringAngle>(
      topic, [this, axle](const SteeringAngle* message, const auto& now, const auto& sender) {
        return message ? adapter_.add(axle, *message, now, sender) : adapter_.addCut();
      });
}

void OdometryRos::subscribeWheels() {
  subscribeToSensor<WheelTicks>(
      "wheel_ticks", [this](const WheelTicks* message, const auto& now, const auto& sender) {
        const Verdict verdict = message ? adapter_.add(*message, now, sender) : adapter_.addCut();
        if (verdict != Verdict::kRivalPublisher) diagnostics_.noteWheels();
        return verdict;
      });
}

void OdometryRos::subscribeJoints() {
  subscribeToSensor<RawJointState>(
      "joint_states", [this](const RawJointState* message, const auto& now, const auto& sender) {
        if (!message) return adapter_.addCut();
        const JointVerdicts verdicts = adapter_.add(*message, now, sender);
        if (verdicts.wheels.value_or(Verdict::kRivalPublisher) != Verdict::kRivalPublisher)
          diagnostics_.noteWheels();
        return verdicts.worst();
      });
}

/// A frame has one parent, and one publisher of where it is (docs/reliability.md, O8).
void OdometryRos::subscribeTransforms() {
  const auto look = [this](const ros::MessageEvent<const tf2_msgs::TFMessage>& event) {
    const std::string& publisher = event.getPublisherName();
    if (publisher == ros::this_node::getName()) return;
    const std::optional<std::string> parent = parentOf(adapter_.frames().base, *event.getConstMessage());
    if (!parent) return;
    const std::string text = publisher + " publishes '" + *parent + "' -> '" + adapter_.frames().base +
                             "' on /tf, too: stop it, or set 'publish_tf: false' here";
    diagnostics_.noteRivalTransform(text);
    if (rival_transform_log_.isDue()) ROS_WARN_STREAM(text);
  };
  namespace traits = ros::message_traits;
  ros::SubscribeOptions options("/tf", kQueueSize, traits::md5sum<tf2_msgs::TFMessage>(),
                                traits::datatype<tf2_msgs::TFMessage>());
  options.helper = boost::make_shared<TransformsCallback>(look);
  options.callback_queue = &transforms_queue_;
  transforms_subscriber_ = node_.subscribe(options);
}

template <typename Add>
void OdometryRos::receive(const char* topic, const Add& add) {
  const ros::Time now = ros::Time::now();
  if (!clock_.runs(now)) return;
  followClock(now);
  // Wheels whose wait has ended come first. Between a tick and its odometry stands only what that needs.
  if (adapter_.deadline()) publishComplete(now);
  const Verdict verdict = add(now);
  publishComplete(now);
  if (verdict == Verdict::kRivalPublisher) diagnostics_.noteRivalInput(topic);
  drop_log_.warn(topic, verdict, adapter_.pipeline().counts());
  warnOfLateDrops();
  wait_timer_.start(adapter_.deadline(), now);
}

void OdometryRos::followClock(const ros::Time& now) {
  if (!clock_.wentBack(now)) return;
  adapter_.clockWentBack(ros::Time::isSimTime());
  early_.deliver();
}

/// Older than any driver sends, while somebody else makes the clock.
bool OdometryRos::isEarly(const ros::Time& stamp) {
  if (!ros::Time::isSimTime() || parameters_.stamp_source == StampSource::kReceipt) return false;
  const ros::Time now = ros::Time::now();
  followClock(now);
  const std::optional<Time> time = toTime(stamp);
  const bool early =
      time && *time != Time() && toTime(now).value_or(Time()) - *time > parameters_.limits.max_gap;
  if (!early) early_.noteTimely();
  return early;
}

void OdometryRos::warnOfLateDrops() {
  const InputCounts& counts = adapter_.pipeline().counts();
  for (const Verdict verdict : {Verdict::kNoSteering, Verdict::kImplausible})
    if (counts[verdict] > known_counts_[verdict]) drop_log_.warn("wheel_ticks", verdict, counts);
  if (counts.counter_restarts > known_counts_.counter_restarts && restart_log_.isDue())
    ROS_WARN("the wheel counters jumped and were taken as a new reference: was the driver restarted?");
  if (counts.ambiguous_gaps > known_counts_.ambiguous_gaps && gap_log_.isDue())
    ROS_ERROR("%s", explainAmbiguousGap());
  if (counts.covariance_repairs > known_counts_.covariance_repairs && repair_log_.isDue())
    ROS_WARN("%s", explainRepair());
  known_counts_ = counts;
}

void OdometryRos::publishComplete(const ros::Time& now) {
  while (const std::optional<OdometryUpdate> update = adapter_.next(now)) publish(*update);
}

void OdometryRos::publishUpdates(const ros::Time& now) {
  publishComplete(now);
  warnOfLateDrops();
  wait_timer_.start(adapter_.deadline(), now);
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
  if (update.report.state != OdometryState::kNominal && state_log_.isDue())
    ROS_WARN("%s", explain(update.report.state));
  warnOfFaults(update.report.sensors);
  diagnostics_.noteUpdate(update);
}

void OdometryRos::warnOfFaults(const SensorReport& sensors) {
  if (sensors.exclusions > known_exclusions_ && fault_log_.isDue()) ROS_WARN_STREAM(explain(sensors));
  if (!sensors.determined && undetermined_log_.isDue()) ROS_ERROR_STREAM(explainUndetermined(sensors));
  known_exclusions_ = sensors.exclusions;
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

void OdometryRos::onSetPose(const geometry_msgs::PoseWithCovarianceStamped* message) {
  publishUpdates(ros::Time::now());
  const std::string refused = message ? adapter_.setPose(*message) : kCut;
  if (refused.empty()) {
    if (pose_set_log_.isDue()) ROS_INFO("the pose was set");
  } else if (pose_refused_log_.isDue()) {
    ROS_WARN_STREAM("set_pose refused: " << refused);
  }
}

void OdometryRos::onCalibration(const CalibrationState* message) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  publishUpdates(ros::Time::now());
  const std::uint64_t before = adapter_.acceptance().taken();
  const std::string refused = message ? adapter_.add(*message) : kCut;
  if (!refused.empty()) {
    if (calibration_refused_log_.isDue()) ROS_WARN_STREAM("message on calibration refused: " << refused);
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
