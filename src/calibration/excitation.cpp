#include "bs_car_odometry/calibration/excitation.hpp"

#include <cmath>

namespace bs_car_odometry::calibration {

namespace {

constexpr double kStraightTurn = 0.02;  // [rad/m]

}  // namespace

void Excitation::add(const BodyMotion& motion) {
  const double path = motion.head<2>().norm();
  const double turn = motion.z();
  distance += path;
  if (std::abs(turn) < kStraightTurn * path) straight += path;
  (turn > 0.0 ? turned_left : turned_right) += std::abs(turn);
}

}  // namespace bs_car_odometry::calibration
