#pragma once

#include "bs_car_odometry/calibration/calibrator.hpp"
#include "bs_car_odometry/calibration/motion_model.hpp"
#include "bs_car_odometry/core/odometry_configuration.hpp"

#include <deque>
#include <optional>

namespace bs_car_odometry::calibration {

/// Pose and twist of base_link after a wheel message.
struct DeadReckonedPose {
  Time stamp;
  Pose2 pose;                  ///< in the map
  Eigen::Matrix3d covariance;  ///< (x, y, yaw)
  BodyMotion twist;            ///< [m/s, m/s, rad/s]
  Eigen::Matrix3d twist_covariance;
  MeasuredStep step;  ///< that led here
};

/// Dead reckoning in the laser's map from the first fix on, each step with the parameters as they were known
/// when it was driven: what the odometry would have been, without a jump (docs/calibration.md, 3).
///     add(update); correct(calibration_update); while (const auto pose = next()) ...
class DeadReckoning {
 public:
  explicit DeadReckoning(const Parameters& parameters);

  /// The next step of the odometry. After one that was not seen, it begins anew at the next fix.
  void add(const OdometryUpdate& update);

  /// Begins where the laser puts the car, the first time; then takes the parameters.
  /// @return true when it began
  bool correct(const CalibrationUpdate& update);

  /// The next pose, once it has begun. It stays, with the covariance of motion that was not seen, where a
  /// step is longer than max_speed allows.
  std::optional<DeadReckonedPose> next();

  /// Begins anew at the next fix.
  void start();

 private:
  struct Waiting {
    OdometryUpdate update;
    MeasuredStep step;
  };

  void begin(const CalibrationUpdate& update);
  bool isPlausible(const TimeSpan& span, const MotionSegment& segment) const;
  void stayUnseen(const TimeSpan& span);
  void move(const MotionSegment& segment);

  OdometryConfiguration configuration_;
  MotionModel model_;
  bool begun_{false};
  std::optional<Time> newest_;
  std::deque<Waiting> waiting_;
  Pose2 pose_;
  Eigen::Matrix3d noise_{Eigen::Matrix3d::Zero()};  ///< of the beginning and of the readings
  /// d pose / d a, where the parameters' errors are root_ a: the same a at all times, which makes errors that
  /// shrink as much as those that stay.
  MotionSensitivity sensitivity_{MotionSensitivity::Zero()};
  Eigen::Matrix<double, kMotionCount, kMotionCount> root_;
};

}  // namespace bs_car_odometry::calibration
