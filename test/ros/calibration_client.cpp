#include "calibration_client.hpp"

#include "odometry_client.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::testing {

namespace {

constexpr std::uint32_t kQueueSize = 5000;
// s of the drive that may be on the way: enough for a first fix, less than a laser pose may be late
constexpr double kAhead = 1.0;

/// What is wrong with a state; empty when nothing is.
std::string violation(const CalibrationState& message) {
  double sum = message.nis + message.weight + message.distance;
  for (const auto* values : {&message.value, &message.deviation, &message.prior_deviation, &message.progress})
    for (const double value : *values) sum += 0.0 * value;
  for (const double value : message.covariance) sum += 0.0 * value;
  for (const double value : message.innovation) sum += 0.0 * value;
  if (!std::isfinite(sum)) return "1: a number is not finite";
  using Matrix = Eigen::Matrix<double, CalibrationState::PARAMETERS, CalibrationState::PARAMETERS>;
  const Matrix P = Eigen::Map<const Matrix>(message.covariance.data());
  if (P != P.transpose()) return "2: the covariance is not symmetric";
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(P, Eigen::EigenvaluesOnly);
  if (solver.eigenvalues().minCoeff() < -1e-12 * std::max(solver.eigenvalues().maxCoeff(), 0.0))
    return "2: the covariance has a negative eigenvalue";
  return "";
}

LaserMessage inMovedMap(LaserMessage message, const Pose2& map) {
  const Pose2 seen = map * toPose(message.pose.pose).value();
  message.pose.pose.position.x = seen.x;
  message.pose.pose.position.y = seen.y;
  message.pose.pose.orientation = toQuaternion(seen.yaw);
  return message;
}

}  // namespace

CalibrationClient::CalibrationClient(const std::string& name)
    : handle_(name), node_("/" + name + "/calibration") {
  XmlRpc::XmlRpcValue parameters;
  ros::param::get("/template", parameters);
  ros::param::set(node_, parameters);
  // Topics keep no order among each other: an angle may come later than its wheels.
  set("steering_wait", 2.0);
  wheels_ = handle_.advertise<WheelTicks>("wheel_ticks", kQueueSize);
  steering_ = handle_.advertise<SteeringAngle>("front_steering", kQueueSize);
  laser_ = handle_.advertise<LaserMessage>("laser_pose", kQueueSize);
  subscribers_.push_back(handle_.subscribe("calibration", kQueueSize, &CalibrationClient::onState, this));
  subscribers_.push_back(handle_.subscribe<nav_msgs::Odometry>(
      "calibrated_odom", kQueueSize, [this](const nav_msgs::Odometry::ConstPtr& message) {
        EXPECT_EQ(invariants_.violation(*message, ros::Time::now()), "") << *message;
        odometry_.push_back(*message);
      }));
}

bool CalibrationClient::start() {
  process_ = std::make_unique<ChildProcess>(std::vector<std::string>{
      BS_CAR_ODOMETRY_CALIBRATION_NODE, "__ns:=" + handle_.getNamespace(), "__name:=calibration"});
  return waitFor([this] {
    return wheels_.getNumSubscribers() > 0 && steering_.getNumSubscribers() > 0 &&
           laser_.getNumSubscribers() > 0 && subscribers_[0].getNumPublishers() > 0 &&
           subscribers_[1].getNumPublishers() > 0 && ros::service::exists(node_ + "/save", false);
  });
}

void CalibrationClient::announceNewRun() {
  invariants_.announceNewRun();
  state_.reset();
  odometry_.clear();
}

void CalibrationClient::onState(const CalibrationState& message) {
  EXPECT_EQ(violation(message), "") << message;
  state_ = message;
}

void CalibrationClient::publish(const SimulatedMessage& message) {
  if (const auto* wheels = std::get_if<WheelTicks>(&message.content)) {
    wheels_.publish(*wheels);
    newest_wheels_ = wheels->header.stamp;
  } else if (const auto* angle = std::get_if<SteeringAngle>(&message.content)) {
    steering_.publish(*angle);
  } else if (const auto* laser = std::get_if<LaserMessage>(&message.content)) {
    newest_laser_ = inMovedMap(*laser, map_);
    laser_.publish(newest_laser_);
  }
}

bool CalibrationClient::drive(SimulatedDrive& drive, double seconds) {
  std::optional<ros::Time> begin;
  ros::Time heard;
  while (const std::optional<SimulatedMessage> message = drive.next()) {
    publish(*message);
    const ros::Time now = toRos(message->receipt);
    if (!begin) begin = heard = now;
    if ((now - *begin).toSec() > seconds) break;
    if ((now - heard).toSec() < kAhead || newest_laser_.header.stamp.isZero()) continue;
    if (!waitForState(newest_laser_.header.stamp - ros::Duration(0.2))) return false;
    heard = now;
  }
  return waitForState(newest_laser_.header.stamp - ros::Duration(0.2));
}

bool CalibrationClient::waitForState(const ros::Time& stamp) {
  return waitFor(
      [&] { return state_ && state_->state != CalibrationState::START && state_->header.stamp >= stamp; });
}

std_srvs::Trigger::Response CalibrationClient::call(const std::string& service) {
  std_srvs::Trigger trigger;
  EXPECT_TRUE(ros::service::call(node_ + "/" + service, trigger));
  return trigger.response;
}

}  // namespace bs_car_odometry::testing
