#pragma once

#include "bs_car_odometry/core/odometry_configuration.hpp"
#include "bs_car_odometry/core/odometry_model.hpp"
#include "bs_car_odometry/core/pose_uncertainty.hpp"
#include "bs_car_odometry/core/steering_doubt.hpp"

#include <memory>
#include <optional>

namespace bs_car_odometry {

/// What is published: pose of base_link in odom, twist (vx, vy, yaw rate) at base_link in base_link.
struct OdometryEstimate {
  Pose2 pose;
  Eigen::Matrix3d pose_covariance;  ///< (x, y, yaw) [m, m, rad]
  Eigen::Vector3d twist;            ///< [m/s, m/s, rad/s]
  Eigen::Matrix3d twist_covariance;
};

/// Dead reckoning, one step at a time: readings to body increment, increment to pose and covariance.
/// Knows nothing of messages, stamps or missing data. No step allocates memory.
class OdometryEstimator {
 public:
  explicit OdometryEstimator(const OdometryConfiguration& configuration);

  /// Back to the initial pose and covariance.
  void reset();

  /// Puts the car at `pose`; the past is forgotten in the covariance too.
  void setPose(const Pose2& pose, const Eigen::Matrix3d& covariance);

  /// Replaces p(A), by a calibration's covariance for instance. What the parameters did to the pose so far
  /// keeps the covariance it had, and is carried on as far as it is due to errors that are still there
  /// (carriedOver()).
  void setSystematicCovariance(const SystematicCovariance& covariance);

  /// Goes on with other values of the parameters; the pose stays.
  void setCalibration(const OdometryCalibration& calibration);

  /// Moves the car by one step of readings.
  /// @param interval  duration of the step; none when it is not known, which leaves no twist.
  /// @return false when the result was not finite: the state is kept and its covariance inflated.
  bool step(const StepReadings& readings, std::optional<Duration> interval) {
    read(readings);
    return move(readings, interval);
  }

  /// The first half of step(): readings to body increment, with their residuals; may be done again.
  const FitResiduals& read(const StepReadings& readings);
  /// The second half: moves the car by what was read last.
  bool move(const StepReadings& readings, std::optional<Duration> interval);
  /// Instead of it: the pose stays, its covariance is inflated, and the twist is not known.
  void refuseStep(std::optional<Duration> interval);

  /// Says how far the angles of the last step may be trusted; the covariances of pose and twist answer for
  /// it.
  /// @param interval  its duration, where it is known
  /// @param sigma     standard deviation of each sensor's angle [rad] beyond its noise; 0 where it is trusted
  void doubtSteering(std::optional<Duration> interval, const PerAxle<double>& sigma);

  /// Adds the covariance of motion that was not seen during `interval`, at up to max_speed.
  void inflate(Duration interval);
  /// Adds the covariance (x, y, yaw) of an error of the pose, axes of odom.
  void inflate(const Eigen::Matrix3d& covariance);

  /// Says that the twist is not known.
  void forgetTwist();

  const OdometryEstimate& estimate() const { return estimate_; }
  const PoseUncertainty& uncertainty() const { return *uncertainty_; }
  /// Where the uncertainty is more than a covariance.
  std::optional<PoseQuantiles> quantiles() { return uncertainty_->quantiles(); }
  const FitResiduals& residuals() const { return increment_.residuals; }
  /// The pose by the readings alone; that of the estimate may be a mean over what they leave open.
  const Pose2& deadReckoned() const { return dead_reckoned_; }
  const BodyIncrement& lastIncrement() const { return increment_; }

 private:
  void publishPose();
  void updateTwist(std::optional<Duration> interval, const SystematicSensitivity& J_motion);

  OdometryConfiguration configuration_;
  OdometryModel model_;
  SystematicRoot systematic_root_;
  std::unique_ptr<PoseUncertainty> uncertainty_;
  SteeringDoubt steering_doubt_;
  BodyIncrement increment_;
  Pose2 dead_reckoned_;
  Pose2 before_step_;  ///< the same before the last step
  OdometryEstimate estimate_;
};

}  // namespace bs_car_odometry
