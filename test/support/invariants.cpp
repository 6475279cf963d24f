#include "support/invariants.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <ros/master.h>
#include <ros/network.h>
#include <xmlrpcpp/XmlRpcClient.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace bs_car_odometry::testing {

namespace {

using Covariance = boost::array<double, 36>;

constexpr std::size_t kMostRecent = 100000;  // messages that may wait for their status

// What the odometry takes for a plausible step, and a stamp that jitters (docs/reliability.md, E3).
constexpr double kPlausibleExcess = 1.5;
constexpr double kStampJitter = 0.01;  // s

bool isFinite(const nav_msgs::Odometry& message) {
  const auto& p = message.pose.pose;
  const auto& t = message.twist.twist;
  double sum = p.position.x + p.position.y + p.position.z + p.orientation.x + p.orientation.y +
               p.orientation.z + p.orientation.w + t.linear.x + t.linear.y + t.linear.z + t.angular.x +
               t.angular.y + t.angular.z;
  // Not the numbers themselves, whose sum may overflow.
  for (const Covariance* covariance : {&message.pose.covariance, &message.twist.covariance})
    for (const double value : *covariance) sum += 0.0 * value;
  return std::isfinite(sum);
}

std::string covarianceViolation(const std::string& name, const Covariance& values) {
  const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> matrix(values.data());
  if (matrix != matrix.transpose()) return "2: the " + name + " covariance is not symmetric";
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(matrix, Eigen::EigenvaluesOnly);
  const double smallest = solver.eigenvalues().minCoeff();
  const double largest = std::max(solver.eigenvalues().maxCoeff(), 0.0);
  if (smallest >= -1e-12 * largest) return "";
  std::ostringstream text;
  text << "2: the " << name << " covariance has the eigenvalue " << smallest << " beside " << largest;
  return text.str();
}

double quaternionNorm(const geometry_msgs::Quaternion& q) {
  return std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
}

double planarVariance(const Covariance& covariance) { return covariance[0] + covariance[7]; }
double yawVariance(const Covariance& covariance) { return covariance[35]; }

/// By how much the step of a message may make the error of the position smaller [m]. The heading's error
/// turns the step, and the same constant errors are in the step as in the pose, so that a car that goes back
/// undoes some of what it has done; the twist says how large they are.
double takenAway(const nav_msgs::Odometry& odom, const OdometryStatus& status) {
  const double step = std::abs(status.step);
  const double in_motion = status.interval * std::sqrt(planarVariance(odom.twist.covariance));
  const double in_turn = status.interval * std::sqrt(yawVariance(odom.twist.covariance));
  return step == 0.0 ? 0.0 : in_motion + step * (std::sqrt(yawVariance(odom.pose.covariance)) + in_turn);
}

}  // namespace

std::string Invariants::violation(const nav_msgs::Odometry& message, const ros::Time& now) {
  if (!isFinite(message)) return "1: a number is not finite";
  if (std::abs(quaternionNorm(message.pose.pose.orientation) - 1.0) > 1e-9)
    return "1: the quaternion is not of unit length";
  for (const auto& [name, covariance] :
       {std::pair("pose", &message.pose.covariance), std::pair("twist", &message.twist.covariance)})
    if (const std::string wrong = covarianceViolation(name, *covariance); !wrong.empty()) return wrong;

  const std::optional<Time> stamp = toTime(message.header.stamp);
  if (!stamp) return "3: the stamp has a second or more in nanoseconds";
  if (const std::string wrong = stampViolation(*stamp, toTime(now).value_or(Time())); !wrong.empty())
    return wrong;
  if (const std::string wrong = stepViolation(message, *stamp); !wrong.empty()) return wrong;
  newest_ = stamp;
  recent_[*stamp] = {message, !previous_};
  previous_ = message;
  if (recent_.size() > kMostRecent) recent_.erase(recent_.begin());
  return "";
}

std::string Invariants::stampViolation(Time stamp, Time now) {
  if (newest_ && stamp <= *newest_) return "3: the stamp is not after the one before";
  if (stamp > now + limits_.max_future) return "3: the stamp is ahead of the clock";
  return "";
}

std::string Invariants::stepViolation(const nav_msgs::Odometry& message, Time stamp) {
  if (!previous_ || !newest_) return "";
  const auto& from = previous_->pose.pose.position;
  const auto& to = message.pose.pose.position;
  const double step = std::hypot(to.x - from.x, to.y - from.y);
  const double longest = limits_.max_speed * (kPlausibleExcess * toSeconds(stamp - *newest_) + kStampJitter);
  // Far from the origin a step is known to within the last digits of the position.
  const double rounding = 1e-15 * (std::abs(from.x) + std::abs(from.y));
  if (step <= longest + rounding) return "";
  std::ostringstream text;
  text << "4: the pose steps by " << step << " m, where " << longest << " m are possible";
  return text.str();
}

std::string Invariants::violation(const OdometryStatus& message) {
  const std::optional<Time> stamp = toTime(message.header.stamp);
  const auto odometry = stamp ? recent_.find(*stamp) : recent_.end();
  if (odometry == recent_.end()) return "6: a status without an odometry of its stamp";
  const nav_msgs::Odometry& odom = odometry->second.message;
  const bool nominal = message.state == OdometryStatus::NOMINAL;
  std::string wrong;
  if (nominal != message.reason.empty())
    wrong = "6: state '" + message.state + "' with the reason '" + message.reason + "'";
  if (previous_status_ && previous_status_->wheel_messages < message.wheel_messages) {
    const OdometryStatus& before = *previous_status_;
    if (!odometry->second.jumped && !growsByUnseenMotion(odom, message))
      wrong = "6: the covariance lacks motion that was not seen";
    const double unknown = limits_.max_speed * limits_.max_speed;
    if (message.gaps > before.gaps && odom.twist.covariance[0] != unknown)
      wrong = "6: the twist of a gap is not said to be unknown";
    if (message.refused_states > before.refused_states && nominal) wrong = "6: a refused state is nominal";
  }
  previous_status_ = message;
  previous_variance_ = planarVariance(odom.pose.covariance);
  recent_.erase(recent_.begin(), std::next(odometry));
  return wrong;
}

/// Not seen is, where the counters restarted, what was before the step, and in a refused state the step.
bool Invariants::growsByUnseenMotion(const nav_msgs::Odometry& odom, const OdometryStatus& message) const {
  const bool restarted = message.counter_restarts > previous_status_->counter_restarts;
  const bool refused = message.refused_states > previous_status_->refused_states;
  if (!restarted && !refused) return true;
  const double since = toSeconds(*toTime(message.header.stamp) - *toTime(previous_status_->header.stamp));
  const double before_step = restarted ? limits_.max_speed * std::max(since - message.interval, 0.0) : 0.0;
  const double in_step = refused ? limits_.max_speed * message.interval : 0.0;
  const double unseen = 2.0 * (before_step * before_step + in_step * in_step);  // along and across
  const double least = std::sqrt(previous_variance_ + unseen) - takenAway(odom, message);
  constexpr double kRounding = 1e-12;
  return std::sqrt(planarVariance(odom.pose.covariance)) >= (1.0 - kRounding) * least;
}

void Invariants::announceNewRun() {
  announceJump();
  newest_.reset();
  previous_status_.reset();
  recent_.clear();
}

int alive(const std::string& node) {
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue payload;
  request[0] = "/invariants";
  request[1] = node;
  if (!ros::master::execute("lookupNode", request, response, payload, false)) return 0;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(static_cast<std::string&>(payload), host, port)) return 0;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller;
  caller[0] = "/invariants";
  XmlRpc::XmlRpcValue answer;
  if (!client.execute("getPid", caller, answer) || answer.size() != 3) return 0;
  return static_cast<int&>(answer[2]);
}

}  // namespace bs_car_odometry::testing
