#pragma once

#include "bs_car_odometry/core/se2.hpp"

#include <optional>

namespace bs_car_odometry::calibration {

/// What the car has done so far, as far as the parameters show by it. Turns and straight legs are told apart
/// over a metre at a time, changes of speed over half a second: shorter pieces show the noise of the
/// encoders.
struct Excitation {
  double distance{0.0};          ///< [m], both ways
  double straight{0.0};          ///< [m] of it with less than 0.02 rad of turn a metre
  double turned_left{0.0};       ///< [rad], the sum of turns to the left
  double turned_right{0.0};      ///< [rad]
  double speed_change{0.0};      ///< [m/s], the sum of changes either way
  double turn_rate_change{0.0};  ///< [rad/s]

  /// @param interval  [s] that the motion took; 0 where it is not known
  void add(const BodyMotion& motion, double interval = 0.0);

 private:
  /// What has not been told apart yet.
  struct Piece {
    double path{0.0};
    double travel{0.0};
    double turn{0.0};
    double duration{0.0};
  };

  void endLeg();
  void endMoment();

  Piece leg_;
  Piece moment_;
  std::optional<double> speed_;
  std::optional<double> turn_rate_;
};

}  // namespace bs_car_odometry::calibration
