#include "bs_car_odometry/ros/calibration_adapter.hpp"

#include "bs_car_odometry/calibration/odometry_for_calibration.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>
#include <variant>

namespace bs_car_odometry {

using calibration::Calibrator;
using calibration::LaserPose;
using calibration::LaserVerdict;

CalibrationAdapter::CalibrationAdapter(const Parameters& parameters)
    : parameters_(parameters),
      odometry_(calibration::odometryForCalibration(parameters)),
      reader_(parameters) {
  if (!parameters.laser.frame.empty())
    mount_finder_ = std::make_unique<LaserMountFinder>(parameters.base_frame, parameters.laser.frame);
  makeCalibrator();
}

void CalibrationAdapter::makeCalibrator() {
  calibrator_ = std::make_unique<Calibrator>(parameters_);
  calibrator_->setListener(listener_);
}

void CalibrationAdapter::setListener(Listener listener) {
  listener_ = std::move(listener);
  calibrator_->setListener(listener_);
}

Verdict CalibrationAdapter::add(const WheelTicks& message, const ros::Time& receipt, const Sender& sender) {
  return odometry_.add(message, receipt, sender);
}

Verdict CalibrationAdapter::add(Axle axle, const SteeringAngle& message, const ros::Time& receipt,
                                const Sender& sender) {
  return odometry_.add(axle, message, receipt, sender);
}

JointVerdicts CalibrationAdapter::add(const RawJointState& message, const ros::Time& receipt,
                                      const Sender& sender) {
  return odometry_.add(message, receipt, sender);
}

LaserVerdict CalibrationAdapter::add(const geometry_msgs::PoseWithCovarianceStamped& message,
                                     const ros::Time& receipt) {
  return count(addLaser(message, receipt));
}

LaserVerdict CalibrationAdapter::count(LaserVerdict verdict) {
  ++laser_counts_.messages;
  ++laser_counts_.verdicts[static_cast<std::size_t>(verdict)];
  return verdict;
}

LaserVerdict CalibrationAdapter::addLaser(const geometry_msgs::PoseWithCovarianceStamped& message,
                                          const ros::Time& receipt) {
  if (mount_finder_) {
    if (!waiting_) waiting_ = Waiting{message.header.stamp, receipt};
    return LaserVerdict::kNoMount;
  }
  const std::variant<LaserPose, LaserVerdict> read = reader_.read(message, receipt);
  if (std::holds_alternative<LaserVerdict>(read)) return std::get<LaserVerdict>(read);
  if (lacksCovariance(message.pose.covariance)) ++laser_counts_.without_covariance;
  return calibrator_->add(std::get<LaserPose>(read));
}

void CalibrationAdapter::add(const tf2_msgs::TFMessage& message) {
  if (!mount_finder_) return;
  mount_finder_->add(message);
  if (mount_finder_->mount()) takeMount(*mount_finder_->mount());
}

void CalibrationAdapter::takeMount(const Pose2& mount) {
  parameters_.laser.x = mount.x;
  parameters_.laser.y = mount.y;
  parameters_.laser.yaw = mount.yaw;
  mount_finder_.reset();
  waiting_.reset();
  makeCalibrator();
}

std::string CalibrationAdapter::waitingForMount(const ros::Time& now) const {
  if (!mount_finder_) return {};
  std::string sentence = "no transform from '" + parameters_.base_frame + "' to '" + parameters_.laser.frame +
                         "' (laser/frame) in tf";
  if (waiting_) {
    std::array<char, 96> wait{};
    std::snprintf(wait.data(), wait.size(), "; laser poses wait for it since stamp %.3f, %.1f s ago",
                  waiting_->stamp.toSec(), now.toSec() - waiting_->since.toSec());
    sentence += wait.data();
  }
  return sentence + ": publish it, or give laser/x, laser/y and laser/yaw instead";
}

std::optional<OdometryUpdate> CalibrationAdapter::next(const ros::Time& now) {
  std::optional<OdometryUpdate> update = odometry_.next(now);
  if (update) calibrator_->add(*update);
  return update;
}

void CalibrationAdapter::finish() {
  while (next(ros::TIME_MAX)) {
  }
}

void CalibrationAdapter::newDrive() {
  odometry_.clockWentBack(true);
  reader_.forgetMap();
  calibrator_->newDrive();
}

void CalibrationAdapter::start() {
  reader_.forgetMap();
  calibrator_->start();
}

void CalibrationAdapter::clockWentBack(bool simulated_time) {
  odometry_.clockWentBack(simulated_time);
  if (simulated_time) {
    start();
  } else {
    calibrator_->newDrive();
  }
}

const char* explain(LaserVerdict verdict) {
  switch (verdict) {
    case LaserVerdict::kAccepted:
    case LaserVerdict::kCount:
      return "";
    case LaserVerdict::kNotFinite:
      return "its position is not finite, or its quaternion's norm is outside 0.9 to 1.1: mend the localiser";
    case LaserVerdict::kBadCovariance:
      return "its covariance of x, y and yaw is not finite or not positive definite: mend the localiser, or "
             "let it send zeros so that 'laser_sigma' holds";
    case LaserVerdict::kOutOfOrder:
      return "it is not newer than a pose that was used already: is only one localiser running?";
    case LaserVerdict::kTooLate:
      return "it came more than 2 s late: lower the localiser's load, or set 'stamp_source: receipt' and "
             "'laser/time_offset'";
    case LaserVerdict::kOverflow:
      return "too many laser poses wait for wheel messages: do wheel_ticks arrive, and with the same clock?";
    case LaserVerdict::kStampZero:
      return "its stamp is zero: stamp poses at the source, or set 'stamp_source: receipt'";
    case LaserVerdict::kStampInvalid:
      return "its stamp has a second or more in nanoseconds: mend the localiser";
    case LaserVerdict::kFuture:
      return "its stamp is ahead of this clock by more than 'max_future': synchronise the clocks";
    case LaserVerdict::kOtherFrame:
      return "it is in another frame than the poses before: is only one localiser running?";
    case LaserVerdict::kNoMount:
      return "tf has not said where 'laser/frame' is";
  }
  return "";
}

std::string explain(const calibration::LocaliserJump& jump) {
  std::array<char, 256> sentence{};
  std::snprintf(
      sentence.data(), sentence.size(),
      "the localiser jumped by %.2f m and %.0f deg at stamp %.3f: the pose is taken anew, the gains "
      "are kept; unless somebody set its pose, check its map and what it sees there",
      jump.distance, jump.turn * 180.0 / M_PI, toRos(jump.stamp).toSec());
  return sentence.data();
}

}  // namespace bs_car_odometry
