#include "odometry_client.hpp"

#include <gtest/gtest.h>
#include <ros/callback_queue.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace bs_car_odometry::testing {

namespace {

constexpr std::uint32_t kQueueSize = 5000;
constexpr double kRetry = 0.5;  // s
constexpr int kTries = 40;

}  // namespace

bool waitFor(const std::function<bool()>& condition, double seconds) {
  const ros::SteadyTime end = ros::SteadyTime::now() + ros::WallDuration(seconds);
  while (!condition()) {
    if (ros::SteadyTime::now() > end || !ros::ok()) return false;
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.01));
  }
  return true;
}

WheelTicks wheelTicks(const Ticks& ticks, const ros::Time& stamp) {
  WheelTicks message;
  message.header.stamp = stamp;
  message.front_left = ticks[0];
  message.front_right = ticks[1];
  message.rear_left = ticks[2];
  message.rear_right = ticks[3];
  return message;
}

SteeringAngle steeringAngle(double angle, const ros::Time& stamp) {
  SteeringAngle message;
  message.header.stamp = stamp;
  message.angle = angle;
  return message;
}

OdometryClient::OdometryClient(const std::string& prefix, const std::string& node)
    : handle_(prefix), node_(node) {
  wheels_ = handle_.advertise<WheelTicks>("wheel_ticks", kQueueSize);
  steering_ = handle_.advertise<SteeringAngle>("front_steering", kQueueSize);
  set_pose_ = handle_.advertise<geometry_msgs::PoseWithCovarianceStamped>("set_pose", kQueueSize);
  reset_ = handle_.serviceClient<std_srvs::Trigger>("odometry/reset");
  subscribers_.push_back(handle_.subscribe("odom", kQueueSize, &OdometryClient::onOdometry, this));
  subscribers_.push_back(handle_.subscribe<OdometryStatus>("odometry_status", kQueueSize,
                                                           [this](const OdometryStatus::ConstPtr& message) {
                                                             status_ = *message;
                                                             unchecked_.push_back(*message);
                                                             checkStatuses();
                                                           }));
  subscribers_.push_back(handle_.subscribe<tf2_msgs::TFMessage>(
      "/tf", kQueueSize, [this](const tf2_msgs::TFMessage::ConstPtr& message) {
        transforms_.insert(transforms_.end(), message->transforms.begin(), message->transforms.end());
      }));
}

bool OdometryClient::connect() {
  const bool connected = waitFor([this] {
    return wheels_.getNumSubscribers() > 0 && steering_.getNumSubscribers() > 0 &&
           set_pose_.getNumSubscribers() > 0 && subscribers_[0].getNumPublishers() > 0 &&
           subscribers_[1].getNumPublishers() > 0;
  });
  process_ = alive(node_);
  return connected && process_ != 0 && reset_.waitForExistence(ros::Duration(20.0));
}

void OdometryClient::onOdometry(const nav_msgs::Odometry& message) {
  if (jumps_allowed_) announceJump();
  EXPECT_EQ(invariants_.violation(message, ros::Time::now()), "") << message;
  odometry_.push_back(message);
  checkStatuses();
}

/// Topics do not keep the order among each other.
void OdometryClient::checkStatuses() {
  while (!unchecked_.empty() && !odometry_.empty() &&
         unchecked_.front().header.stamp <= odometry_.back().header.stamp) {
    EXPECT_EQ(invariants_.violation(unchecked_.front()), "") << unchecked_.front();
    unchecked_.pop_front();
  }
}

std::optional<nav_msgs::Odometry> OdometryClient::step(const Ticks& ticks, double angle) {
  for (int i = 0; i < kTries; ++i) {
    const ros::Time stamp = ros::Time::now();
    send(steeringAngle(angle, stamp));
    send(wheelTicks(ticks, stamp));
    const auto there = [&] {
      return !odometry_.empty() && odometry_.back().header.stamp == stamp && status_.header.stamp == stamp;
    };
    if (waitFor(there, kRetry)) return odometry_.back();
  }
  return std::nullopt;
}

bool OdometryClient::reset() {
  std_srvs::Trigger trigger;
  const bool done = reset_.call(trigger) && trigger.response.success;
  announceJump();
  return done;
}

DiagnosticsListener::DiagnosticsListener() {
  subscriber_ =
      ros::NodeHandle().subscribe("/diagnostics", kQueueSize, &DiagnosticsListener::onDiagnostics, this);
}

void DiagnosticsListener::onDiagnostics(const diagnostic_msgs::DiagnosticArray& message) {
  for (const auto& status : message.status) heard_.push_back({ros::SteadyTime::now(), status});
}

bool DiagnosticsListener::has(const std::string& name, int level, const std::string& text) const {
  return std::any_of(heard_.begin(), heard_.end(), [&](const Heard& heard) {
    return heard.status.name == name && heard.status.level == level &&
           heard.status.message.find(text) != std::string::npos;
  });
}

bool DiagnosticsListener::waitForStatus(const std::string& name, int level, const std::string& text) {
  return waitFor([&] { return has(name, level, text); });
}

std::vector<ros::SteadyTime> DiagnosticsListener::timesOf(const std::string& name) const {
  std::vector<ros::SteadyTime> times;
  for (const Heard& heard : heard_)
    if (heard.status.name == name) times.push_back(heard.time);
  return times;
}

LogListener::LogListener() {
  subscriber_ = ros::NodeHandle().subscribe<rosgraph_msgs::Log>(
      "/rosout", kQueueSize,
      [this](const rosgraph_msgs::Log::ConstPtr& message) { lines_.push_back(*message); });
}

std::size_t LogListener::count(const std::string& text, int level) const {
  return static_cast<std::size_t>(
      std::count_if(lines_.begin(), lines_.end(), [&](const rosgraph_msgs::Log& line) {
        return line.level >= level && line.msg.find(text) != std::string::npos;
      }));
}

std::size_t LogListener::countOf(const std::string& node) const {
  return static_cast<std::size_t>(std::count_if(
      lines_.begin(), lines_.end(), [&](const rosgraph_msgs::Log& line) { return line.name == node; }));
}

bool LogListener::waitForLine(const std::string& text, int level, double seconds) {
  return waitFor([&] { return count(text, level) > 0; }, seconds);
}

ProcessSize sizeOf(int process) {
  const std::string folder = "/proc/" + std::to_string(process);
  ProcessSize size;
  std::ifstream status(folder + "/status");
  for (std::string word; status >> word;) {
    if (word == "VmRSS:") status >> size.resident;
    if (word == "Threads:") status >> size.threads;
  }
  size.resident /= 1024.0;  // from kB
  using Files = std::filesystem::directory_iterator;
  size.files = static_cast<int>(std::distance(Files(folder + "/fd"), Files()));
  return size;
}

int runTests(int argc, char** argv, const std::string& name) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, name);
  const ros::NodeHandle keeps_ros_alive;
  return RUN_ALL_TESTS();
}

}  // namespace bs_car_odometry::testing
