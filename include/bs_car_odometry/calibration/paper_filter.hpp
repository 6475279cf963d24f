#pragma once

#include "bs_car_odometry/calibration/distance_gain_filter.hpp"
#include "bs_car_odometry/calibration/filter.hpp"
#include "bs_car_odometry/calibration/motion_model.hpp"

#include <Eigen/Core>

#include <memory>
#include <vector>

namespace bs_car_odometry::calibration {

/// P1's calibration of one axle, corrected (docs/calibration.md, 1): k_d on a straight run, then an extended
/// Kalman filter of X = (x, y, theta, k_r, k_b) whose left gain follows from k_r and k_d by (C3). What is not
/// known of k_d is carried along as a consider (Schmidt) state: it widens the covariance and is not updated.
class PaperFilter final : public Filter {
 public:
  /// @param parameters  with `odometry/axles` front or rear
  explicit PaperFilter(const Parameters& parameters);

  void begin(const LaserPose& laser) override;
  void move(const MeasuredStep& step) override;
  Innovation update(const LaserPose& laser, double lead) override;
  FilterEstimate estimate() const override;
  double timeOffset() const override { return model_.values()[kTimeOffset]; }
  std::unique_ptr<Filter> clone() const override { return std::make_unique<PaperFilter>(*this); }

  void setStraightRun(bool lasts) override;
  void takeTapedRun(const std::vector<MeasuredStep>& run, double distance) override;

  /// Ends stage 1 with a distance gain from elsewhere.
  /// @param run  the travels that it was found with
  void setDistanceGain(double k_d, double variance, const StraightRun& run);

  /// The travels of stage 1.
  const StraightRun& straightRun() const { return run_; }

 private:
  enum StateIndex { kX, kY, kYaw, kRight, kTrack, kDistanceGain, kStates };
  using StateMatrix = Eigen::Matrix<double, kStates, kStates>;
  using MeasurementJacobian = Eigen::Matrix<double, 3, kStates>;

  struct State {
    Pose2 pose;             ///< base_link in the map
    Eigen::Vector3d gains;  ///< k_r, k_b, k_d
    StateMatrix P;
  };

  /// How long stage 1 lasts.
  enum class StraightEnd { kByAngle, kWhenTold, kOver };

  void setPose(const LaserPose& laser);
  void setGains(double k_d, double variance);
  void beginStage2(const LaserPose& laser);
  void followStraightRun(const MeasuredStep& step);
  void addToRun(const MeasuredStep& step);
  void beginDistance(const LaserPose& laser);
  void measureDistance(const LaserPose& laser, double yaw, double weight);
  State predicted() const;
  Eigen::Matrix3d gainColumns(const MotionSensitivity& J) const;
  MeasurementJacobian measurementJacobian(const Pose2& base) const;
  bool correct(const State& state, const LaserPose& laser, const Innovation& innovation);
  void useGains();

  Vehicle vehicle_;  ///< as configured
  Axle axle_;
  Eigen::Index first_;     ///< of the axle's k_r, k_l, k_b among the parameters
  Eigen::Vector3d prior_;  ///< their values
  Eigen::Vector3d prior_variance_;
  double wheel_variance_;  ///< c^2 [m]
  double straight_limit_;  ///< [rad]
  Pose2 mount_;            ///< the laser's point in base_link

  int stage_{1};
  StraightEnd straight_end_{StraightEnd::kByAngle};
  bool begun_{false};                    ///< there has been a pose
  DistanceGainFilter distance_;          ///< stage 1
  StraightRun run_;                      ///< travels that it has seen
  double angle_{0.0};                    ///< [rad] of the axle in the last step
  Eigen::Vector2d reference_{0.0, 0.0};  ///< where the last pose that was believed saw the axle's middle [m]
  double reference_distance_{0.0};       ///< and how far along the run that is [m]

  StraightRun relation_;  ///< that k_l follows from k_r and k_d with
  MotionModel model_;
  State state_;            ///< where the segment begins
  MotionSegment segment_;  ///< motion since
};

}  // namespace bs_car_odometry::calibration
