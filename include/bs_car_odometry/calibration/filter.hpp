#pragma once

#include "bs_car_odometry/calibration/calibrated_parameters.hpp"
#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/core/se2.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace bs_car_odometry::calibration {

/// A pose of the laser's point P in the map (docs/interface.md, laser_pose).
struct LaserPose {
  Time stamp;
  Pose2 pose;
  Eigen::Matrix3d covariance;  ///< (x, y, yaw) [m, m, rad], in the map's axes
};

/// How a laser pose agrees with what was expected.
struct Innovation {
  Eigen::Vector3d residual{Eigen::Vector3d::Zero()};    ///< measured less expected (x, y, yaw), yaw wrapped
  Eigen::Matrix3d covariance{Eigen::Matrix3d::Zero()};  ///< of the residual, S = H P H^T + R
  double nis{0.0};     ///< d^2 = r^T S^-1 r: chi-square, 3 degrees of freedom
  double weight{1.0};  ///< below 1 where the pose was believed less than its R
};

/// What a filter believes.
struct FilterEstimate {
  Pose2 pose;  ///< base_link in the map
  Eigen::Matrix3d pose_covariance{Eigen::Matrix3d::Zero()};
  ParameterVector values{ParameterVector::Zero()};
  ParameterMatrix covariance{ParameterMatrix::Zero()};  ///< zero for what is not estimated
  Eigen::Matrix<double, 3, kCount> cross{Eigen::Matrix<double, 3, kCount>::Zero()};  ///< of pose and values
  PerAxle<double> k_d;  ///< distance gain of each axle (docs/calibration.md, 1)
  PerAxle<double> k_d_variance;
  int stage{0};  ///< paper: 1 while the distance gain is found, then 2; joint: 0
};

/// From motion and laser poses to parameters. Knows no queues, clocks or jumps: Calibrator gives it pieces of
/// steps and the laser pose at their end, in order of time.
class Filter {
 public:
  virtual ~Filter() = default;

  /// Begins at a laser pose; the parameters stay as they are.
  virtual void begin(const LaserPose& laser) = 0;

  /// Moves on by a step, or by a part of one.
  virtual void move(const MeasuredStep& step) = 0;

  /// Takes a laser pose at the present instant.
  /// @param lead  [s] by how much the pose is later than the last step's end; a few milliseconds at most,
  ///              negative where the time offset has moved on
  virtual Innovation update(const LaserPose& laser, double lead) = 0;

  virtual FilterEstimate estimate() const = 0;

  /// The shift that a pose's stamp has by the present estimate [s].
  virtual double timeOffset() const = 0;

  /// Takes over parameters and their covariance; the pose becomes unknown.
  /// @return false, with nothing done, when these are not all that the filter's state consists of
  virtual bool restore(const ParameterVector& /*values*/, const ParameterMatrix& /*covariance*/) {
    return false;
  }

  /// Works out every derivative at these values from now on, or again at the present ones; right after an
  /// update or the beginning.
  /// @return false when it cannot
  virtual bool lineariseAt(const std::optional<ParameterVector>& /*values*/) { return false; }

  /// `calibration/method: paper`, stage 1 lasts from now on until told that it is over, whatever the angle;
  /// or is over. Nothing to other methods.
  virtual void setStraightRun(bool /*lasts*/) {}

  /// `calibration/method: paper`, stage 1 without a laser: a run one way, whose length was taken with a tape.
  /// Stage 2 begins at the next laser pose. Nothing to other methods.
  /// @param run       from rest to rest
  /// @param distance  [m], above zero
  virtual void takeTapedRun(const std::vector<MeasuredStep>& /*run*/, double /*distance*/) {}

  /// With everything it knows.
  virtual std::unique_ptr<Filter> clone() const = 0;

 protected:
  Filter() = default;
  Filter(const Filter&) = default;
  Filter& operator=(const Filter&) = default;
};

/// The filter that `calibration/method` selects.
std::unique_ptr<Filter> makeFilter(const Parameters& parameters);

/// Fills in the distance gains that follow from the gains of each axle's wheels.
void setDistanceGains(const Vehicle& vehicle, FilterEstimate& estimate);

/// Squared Mahalanobis distances: beyond the first a pose is believed less (t = 3), beyond the second it
/// counts as rejected (0.1 % of a chi-square with 3 degrees of freedom).
constexpr double kSoftLimit = 9.0;
constexpr double kRejectLimit = 16.2662;

}  // namespace bs_car_odometry::calibration
