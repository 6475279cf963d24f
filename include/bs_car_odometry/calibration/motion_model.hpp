#pragma once

#include "bs_car_odometry/calibration/calibrated_parameters.hpp"
#include "bs_car_odometry/calibration/evidence.hpp"
#include "bs_car_odometry/calibration/track_noise.hpp"
#include "bs_car_odometry/core/odometry_model.hpp"
#include "bs_car_odometry/core/odometry_pipeline.hpp"

#include <utility>

namespace bs_car_odometry::calibration {

/// d(motion)/d(parameters that move the car), row by row in memory like SystematicSensitivity.
using MotionSensitivity = Eigen::Matrix<double, 3, kMotionCount, Eigen::RowMajor>;

/// Motion of base_link over some steps, seen from where they begin, with everything that a filter or a fit
/// needs of them (docs/calibration.md, 2).
struct MotionSegment {
  Pose2 motion;                                    ///< pose at the end in base_link at the beginning
  Eigen::Matrix3d noise{Eigen::Matrix3d::Zero()};  ///< covariance of motion (x, y, yaw) from the readings
  MotionSensitivity J{MotionSensitivity::Zero()};  ///< d motion / d parameters
  Eigen::Matrix<double, 3, 2> doubt{Eigen::Matrix<double, 3, 2>::Zero()};  ///< see SteeringDoubt
  BodyMotion twist{BodyMotion::Zero()};  ///< over the last 0.06 s [m/s, m/s, rad/s]
  TrackNoise track_noise;  ///< as if the errors were of the beginning: J_beginning() carries it to the end
  Evidence evidence;       ///< of the same readings
  double distance{0.0};    ///< [m], path length
  double duration{0.0};    ///< [s]

  PendingReadings pending;  ///< not in the evidence yet

  /// The segment that begins where this one ends: the velocity goes on, and so do the pending readings.
  MotionSegment next() const {
    MotionSegment next;
    next.twist = twist;
    next.pending = pending;
    return next;
  }

  /// F of the whole segment: derivative of its end with respect to its beginning.
  Eigen::Matrix3d J_beginning() const {
    PoseStep moved;
    moved.dx = motion.x;
    moved.dy = motion.y;
    return moved.J_pose_pose();
  }

  /// Covariance of motion: that of the readings, and of angles that could not be trusted.
  Eigen::Matrix3d covariance() const { return noise + doubt * doubt.transpose(); }
};

/// From readings to motion for any values of the parameters: the odometry's own model, built anew for each
/// set of values.
class MotionModel {
 public:
  explicit MotionModel(const Parameters& parameters);

  /// The values that motion and sensitivities are worked out at from now on.
  void setValues(const ParameterVector& values);
  const ParameterVector& values() const { return values_; }
  const Vehicle& vehicle() const { return configuration_.vehicle; }

  /// The readings of a step, as taken with the configured values, with the present ones.
  StepReadings adapted(const StepReadings& readings) const;

  /// Moves a pose by a step.
  /// @return the length of the way [m]
  double move(const MeasuredStep& step, Pose2& pose) const;

  /// Lengthens a segment by a step.
  void extend(const MeasuredStep& step, MotionSegment& segment) const;

 private:
  BodyIncrement increment(const StepReadings& readings) const {
    return std::visit([&](const auto& model) { return model.increment(readings); }, model_);
  }
  void compare(const MeasuredStep& step, MotionSegment& segment) const;
  void addEvidence(const StepReadings& readings, Evidence& evidence) const;
  MotionSensitivity sensitivity(const SystematicSensitivity& J, const StepReadings& readings) const;

  OdometryConfiguration configuration_;  ///< with the present values
  Vehicle configured_;                   ///< with those that the readings were taken with
  ParameterVector values_;
  PerWheel<double> gain_ratio_{{1.0, 1.0, 1.0, 1.0}};  ///< present gains over the configured ones
  OdometryModel model_;
  double comparison_length_;  ///< [m], of the readings that are compared with each other at once
};

/// The parts of a step before and after `time`, which lies inside it, at constant speed and steering rate.
std::pair<MeasuredStep, MeasuredStep> split(const MeasuredStep& step, Time time);

}  // namespace bs_car_odometry::calibration
