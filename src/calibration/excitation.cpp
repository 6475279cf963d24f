#include "bs_car_odometry/calibration/excitation.hpp"

#include <cmath>

namespace bs_car_odometry::calibration {

namespace {

constexpr double kStraightTurn = 0.02;  // [rad/m]
constexpr double kLeg = 1.0;            // [m]
constexpr double kLegTurn = 0.2;        // [rad], of a car that turns on the spot
constexpr double kMoment = 0.5;         // [s]
constexpr double kSameSpeed = 0.1;      // [m/s]
constexpr double kSameTurnRate = 0.05;  // [rad/s]

/// Adds the change to a sum, unless it may be noise.
void follow(double value, double same, std::optional<double>& reference, double& sum) {
  const double change = std::abs(value - reference.value_or(value));
  if (reference && change <= same) return;
  sum += change;
  reference = value;
}

}  // namespace

void Excitation::add(const BodyMotion& motion, double interval) {
  const double path = motion.head<2>().norm();
  distance += path;
  for (Piece* piece : {&leg_, &moment_}) {
    piece->path += path;
    piece->travel += motion.x();
    piece->turn += motion.z();
    piece->duration += interval;
  }
  if (leg_.path >= kLeg || std::abs(leg_.turn) >= kLegTurn) endLeg();
  if (moment_.duration >= kMoment) endMoment();
}

void Excitation::endLeg() {
  if (std::abs(leg_.turn) < kStraightTurn * leg_.path) {
    straight += leg_.path;
  } else {
    (leg_.turn > 0.0 ? turned_left : turned_right) += std::abs(leg_.turn);
  }
  leg_ = Piece();
}

void Excitation::endMoment() {
  follow(moment_.travel / moment_.duration, kSameSpeed, speed_, speed_change);
  follow(moment_.turn / moment_.duration, kSameTurnRate, turn_rate_, turn_rate_change);
  moment_ = Piece();
}

}  // namespace bs_car_odometry::calibration
