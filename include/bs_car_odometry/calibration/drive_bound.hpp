#pragma once

#include "bs_car_odometry/calibration/cramer_rao_bound.hpp"
#include "bs_car_odometry/calibration/motion_model.hpp"

#include <vector>

namespace bs_car_odometry::calibration {

/// The bound along a drive by the package's own model (MotionModel), at true parameters.
class DriveBound {
 public:
  /// @param truth      with the true values; its noise model is that of the bound
  /// @param estimated  the parameters that are not known
  /// @param prior      their standard deviations; kDiffuse for none
  DriveBound(const Parameters& truth, const ParameterMask& estimated, const ParameterVector& prior);

  /// True motion.
  /// @param step  readings without noise, as taken with the true values
  void move(const MeasuredStep& step);

  /// A laser pose is measured now.
  /// @param R  its covariance (x, y, yaw)
  void update(const Eigen::Matrix3d& R);

  /// Another drive, or motion that was not seen: the pose is not known any more.
  void newDrive();

  /// Of the parameters; 0 for those not estimated.
  ParameterMatrix covariance() const;

  /// Standard deviations of the parameters; 0 for those not estimated.
  ParameterVector deviations() const;

 private:
  CramerRaoBound::PoseSensitivity selected(const Eigen::Matrix<double, 3, kCount>& J) const;
  Eigen::MatrixXd selected(const Eigen::Matrix<double, kMotionCount, kMotionCount>& information) const;
  void predict();

  MotionModel model_;
  LaserMount mount_;
  std::vector<std::size_t> estimated_;
  CramerRaoBound bound_;
  Pose2 pose_;             ///< from the start, which is the origin: the bound does not depend on it
  MotionSegment segment_;  ///< since the last laser pose
};

}  // namespace bs_car_odometry::calibration
