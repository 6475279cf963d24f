#include "bs_car_odometry/calibration/track_noise.hpp"

namespace bs_car_odometry::calibration {

void TrackNoise::add(const BodyIncrement& increment, const Eigen::Matrix3d& G) {
  const double turn = increment.motion.z();
  if (turn == 0.0) return;
  const Eigen::Vector3d front = G * increment.J_motion_systematic.col(systematic::kFrontTrack) / turn;
  const Eigen::Vector3d rear = G * increment.J_motion_systematic.col(systematic::kRearTrack) / turn;
  const Eigen::Vector3d with_turn = G * increment.path_covariance.col(2);
  const double variance = increment.path_covariance(2, 2);
  with_motion.front += front * with_turn.transpose();
  with_motion.rear += rear * with_turn.transpose();
  own.front += variance * front * front.transpose();
  own.rear += variance * rear * rear.transpose();
}

void TrackNoise::transform(const Eigen::Matrix3d& A) {
  for (Eigen::Matrix3d* part : {&with_motion.front, &with_motion.rear, &own.front, &own.rear})
    *part = A * *part * A.transpose();
}

TrackNoise& TrackNoise::operator+=(const TrackNoise& other) {
  with_motion.front += other.with_motion.front;
  with_motion.rear += other.with_motion.rear;
  own.front += other.own.front;
  own.rear += other.own.rear;
  return *this;
}

}  // namespace bs_car_odometry::calibration
