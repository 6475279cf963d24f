#include "dead_reckoning.hpp"

#include "bs_car_odometry/calibration/planar.hpp"

namespace bs_car_odometry::tools {

using namespace calibration;

std::vector<ReckonedPose> deadReckon(const CalibrationDrive& drive, const Parameters& parameters,
                                     const ParameterVector& values, const std::vector<bool>& good) {
  const Pose2 from_laser = inverse(mountOf(values));
  const Duration late = durationFromSeconds(values[kTimeOffset]);
  MotionModel model(parameters);
  model.setValues(values);
  Pose2 pose;
  double distance = 0.0;
  DriveWalk walk(drive);
  std::vector<ReckonedPose> path;
  bool interrupted = true;
  for (std::size_t i = 0; i < drive.lasers().size(); ++i) {
    const DriveLaser& laser = drive.lasers()[i];
    const auto move = [&](const MeasuredStep& step) { distance += model.move(step, pose); };
    interrupted = !walk.moveTo(laser.laser.stamp - late, move) || interrupted || laser.jumped;
    if (!good[i]) continue;
    const Pose2 measured = laser.laser.pose * from_laser;
    if (interrupted) {
      distance = path.empty() ? 0.0 : path.back().distance;
      pose = measured;
    }
    path.push_back({i, measured, pose, interrupted, distance});
    interrupted = false;
  }
  return path;
}

Drift driftOf(const std::vector<ReckonedPose>& path) {
  Drift drift;
  for (std::size_t i = 0; i < path.size(); ++i)
    if (i + 1 == path.size() || path[i + 1].begins)
      drift.error += (path[i].reckoned.position() - path[i].measured.position()).norm();
  if (!path.empty()) drift.distance = path.back().distance;
  return drift;
}

}  // namespace bs_car_odometry::tools
