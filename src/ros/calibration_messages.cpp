#include "bs_car_odometry/ros/calibration_messages.hpp"

#include "bs_car_odometry/calibration/observability.hpp"
#include "bs_car_odometry/ros/conversions.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

using calibration::CalibrationStage;
using calibration::Calibrator;
using calibration::FilterEstimate;
using calibration::Innovation;
using calibration::Knowledge;

namespace {

static_assert(static_cast<int>(calibration::kCount) == static_cast<int>(CalibrationState::PARAMETERS),
              "the message has room for every parameter");

std::uint8_t stateOf(CalibrationStage stage) {
  switch (stage) {
    case CalibrationStage::kStart:
      return CalibrationState::START;
    case CalibrationStage::kRunning:
      return CalibrationState::RUNNING;
    case CalibrationStage::kConverged:
      return CalibrationState::CONVERGED;
  }
  return CalibrationState::START;
}

template <typename Vector, typename Array>
void copy(const Vector& from, Array& to) {
  std::copy(from.data(), from.data() + from.size(), to.begin());
}

void fillEstimate(const FilterEstimate& estimate, CalibrationState& message) {
  message.stage = static_cast<std::uint8_t>(estimate.stage);
  for (const Axle axle : kAllAxles) {
    message.k_d[index(axle)] = estimate.k_d[axle];
    message.k_d_deviation[index(axle)] = std::sqrt(std::max(estimate.k_d_variance[axle], 0.0));
  }
  copy(estimate.values, message.value);
  // Symmetric to the last digit: columns may stand for rows.
  const calibration::ParameterMatrix covariance =
      0.5 * (estimate.covariance + estimate.covariance.transpose());
  copy(covariance, message.covariance);
}

void fillKnowledge(const Knowledge& knowledge, CalibrationState& message) {
  copy(knowledge.deviation, message.deviation);
  copy(knowledge.prior, message.prior_deviation);
  for (std::size_t i = 0; i < calibration::kCount; ++i) {
    message.estimated[i] = knowledge.estimated[i];
    message.observed[i] = knowledge.observed(i);
    message.progress[i] = progress(knowledge, i);
  }
  message.distance = knowledge.excitation.distance;
  message.missing = missing(knowledge);
}

void fillInnovation(const Innovation& innovation, CalibrationState& message) {
  copy(innovation.residual, message.innovation);
  message.nis = innovation.nis;
  message.weight = innovation.weight;
}

}  // namespace

void fillCalibrationState(const Calibrator& calibrator, CalibrationMethod method, CalibrationState& message) {
  message.state = stateOf(calibrator.stage());
  message.method = method == CalibrationMethod::kPaper ? CalibrationState::PAPER : CalibrationState::JOINT;
  fillEstimate(calibrator.estimate(), message);
  fillKnowledge(knowledgeOf(calibrator), message);
  fillInnovation(calibrator.innovation(), message);
  message.accepted = calibrator.counts().used;
  message.rejected = calibrator.counts().rejected;
  message.dropped = calibrator.counts().dropped;
  message.relocalisations = calibrator.counts().relocalisations;
}

void fillOdometry(const calibration::DeadReckonedPose& pose, const std::string& map_frame,
                  const std::string& base_frame, double unmeasured_variance, nav_msgs::Odometry& message) {
  message.header.stamp = toRos(pose.stamp);
  message.header.frame_id = map_frame;
  message.child_frame_id = base_frame;
  message.pose.pose.position.x = pose.pose.x;
  message.pose.pose.position.y = pose.pose.y;
  message.pose.pose.orientation = toQuaternion(pose.pose.yaw);
  message.pose.covariance = toCovariance(pose.covariance, unmeasured_variance);
  message.twist.twist.linear.x = pose.twist.x();
  message.twist.twist.linear.y = pose.twist.y();
  message.twist.twist.angular.z = pose.twist.z();
  message.twist.covariance = toCovariance(pose.twist_covariance, unmeasured_variance);
}

nav_msgs::Path toPath(const std::vector<Pose2>& poses, const std_msgs::Header& header) {
  nav_msgs::Path path;
  path.header = header;
  path.poses.resize(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    path.poses[i].header = header;
    path.poses[i].pose.position.x = poses[i].x;
    path.poses[i].pose.position.y = poses[i].y;
    path.poses[i].pose.orientation = toQuaternion(poses[i].yaw);
  }
  return path;
}

calibration::CalibrationResult resultOf(const Calibrator& calibrator) {
  calibration::CalibrationResult result;
  const FilterEstimate estimate = calibrator.estimate();
  result.values = estimate.values;
  result.covariance = estimate.covariance;
  result.listed = calibrator.observed();
  for (std::size_t i = 0; i < calibration::kCount; ++i)
    result.not_observed[i] = calibrator.estimated()[i] && !result.listed[i];
  if (calibrator.span()) {
    result.data.from = toRos(calibrator.span()->begin).toSec();
    result.data.to = toRos(calibrator.span()->end).toSec();
  }
  result.data.distance = calibrator.excitation().distance;
  result.data.laser_poses = calibrator.counts().used;
  result.data.rejected = calibrator.counts().rejected;
  return result;
}

}  // namespace bs_car_odometry
