#pragma once

#include "bs_car_odometry/calibration/filter.hpp"
#include "bs_car_odometry/calibration/motion_model.hpp"

#include <Eigen/Core>

#include <vector>

namespace bs_car_odometry::calibration {

/// Extended Kalman filter of pose and parameters together (docs/calibration.md, section 2): no gain is found
/// before the others and taken as known. Joseph form, wrapped heading, weights against outliers, and motion
/// between two laser poses as one segment. Allocates where the model is built anew, after each laser pose.
class JointFilter final : public Filter {
 public:
  /// @param takes_out_track_noise  false: the textbook's filter, without (C14)
  explicit JointFilter(const Parameters& parameters, bool takes_out_track_noise = true);

  void begin(const LaserPose& laser) override;
  void move(const MeasuredStep& step) override { model_.extend(step, segment_); }
  Innovation update(const LaserPose& laser, double lead) override;
  FilterEstimate estimate() const override;
  double timeOffset() const override { return state_.values[kTimeOffset]; }
  bool restore(const ParameterVector& values, const ParameterMatrix& covariance) override;
  bool lineariseAt(const std::optional<ParameterVector>& values) override;
  std::unique_ptr<Filter> clone() const override { return std::make_unique<JointFilter>(*this); }

 private:
  static constexpr int kMostStates = 3 + static_cast<int>(kCount);
  using StateMatrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostStates, kMostStates>;
  using MeasurementJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMostStates>;
  using Gain = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, kMostStates, 3>;
  using StateVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostStates, 1>;

  struct State {
    Pose2 pose;
    ParameterVector values;
    StateMatrix P;           ///< of (x, y, yaw) and the parameters in active_
    TrackNoise track_noise;  ///< in P: of the pose's sensitivity to the tracks
  };

  /// The state at the end of the segment.
  State predicted() const;
  /// How far the estimate is from the values of the model.
  Eigen::Matrix<double, kMotionCount, 1> offModel() const;
  Pose2 motion() const;
  void takeEvidence(State& state) const;
  void shift(const StateVector& change, State& state) const;
  /// Columns of a matrix over all parameters that belong to the estimated ones.
  MeasurementJacobian columns(const Eigen::Matrix<double, 3, kCount>& J) const;
  MeasurementJacobian measurementJacobian(const State& state) const;
  Pose2 expectedLaser(const State& state, double lead) const;
  /// Velocity of the laser's point in the map [m/s, m/s, rad/s].
  Eigen::Vector3d laserVelocity(const State& state) const;
  StateVector velocityBias(const MeasurementJacobian& H, const Eigen::Matrix3d& S,
                           const StateMatrix& P) const;
  void removeTrackNoise(const Eigen::Matrix3d& M, State& state) const;
  double shareTowardsPrior(std::size_t parameter, double change, const State& state) const;
  bool correct(const State& state, const MeasurementJacobian& H, const Eigen::Matrix3d& laser_covariance,
               const Innovation& innovation);

  std::vector<std::size_t> active_;  ///< estimated parameters
  bool takes_out_track_noise_;
  ParameterVector random_walk_;  ///< variance a metre
  ParameterVector prior_;        ///< values before the drive
  ParameterVector prior_variance_;
  MotionModel model_;
  State state_;            ///< where the segment begins
  MotionSegment segment_;  ///< motion since
  bool elsewhere_{false};  ///< the model does not follow the estimate, see lineariseAt()
};

}  // namespace bs_car_odometry::calibration
