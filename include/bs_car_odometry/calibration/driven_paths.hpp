#pragma once

#include "bs_car_odometry/calibration/calibrator.hpp"
#include "bs_car_odometry/calibration/motion_model.hpp"

#include <optional>
#include <vector>

namespace bs_car_odometry::calibration {

/// The drive since the first fix, in pieces of equal length, for any values of the parameters: each piece
/// keeps its motion with the configured values and the derivative by the parameters, which is all that a few
/// decimetres need. Of a long drive the pieces get longer, not more.
class DrivenPaths {
 public:
  explicit DrivenPaths(const Parameters& parameters);

  void add(const MeasuredStep& step);
  void add(const CalibrationUpdate& update);
  void start();

  /// base_link in the map by dead reckoning with these values.
  std::vector<Pose2> path(const ParameterVector& values) const;
  /// base_link in the map by the laser.
  const std::vector<Pose2>& laserPath() const { return laser_; }
  const ParameterVector& configured() const { return model_.values(); }

  static constexpr std::size_t kMostPoses = 2000;

 private:
  struct Piece {
    Pose2 motion;
    MotionSensitivity J;
  };

  static Piece joined(const Piece& first, const Piece& second);
  void halve();

  MotionModel model_;
  double spacing_;
  std::optional<Pose2> begin_;
  MotionSegment segment_;
  std::vector<Piece> pieces_;
  std::vector<Pose2> laser_;
  double laser_distance_{0.0};  ///< of the last laser pose that was kept [m]
};

}  // namespace bs_car_odometry::calibration
