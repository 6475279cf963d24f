#include "dead_reckoning.hpp"

#include "bs_car_odometry/calibration/motion_model.hpp"

#include <optional>

namespace bs_car_odometry::tools {

using namespace calibration;

namespace {

/// Goes through the steps of a drive and keeps the pose.
class Reckoner {
 public:
  Reckoner(const CalibrationDrive& drive, const Parameters& parameters, const ParameterVector& values)
      : drive_(drive), model_(parameters) {
    model_.setValues(values);
  }

  /// Moves on to a time inside the steps.
  /// @return false when motion on the way was not seen, or there are no steps so far
  bool moveTo(Time time) {
    bool seen = true;
    for (; next_ < drive_.steps(); ++next_) {
      MeasuredStep step = drive_.step(next_);
      if (now_ && step.span.begin > *now_ && step.span.begin <= time) seen = false;
      if (step.span.begin >= time) break;
      if (now_ && *now_ > step.span.begin) step = split(step, *now_).second;
      if (step.span.end > time) {
        model_.extend(split(step, time).first, segment_);
        now_ = time;
        return seen;
      }
      model_.extend(step, segment_);
      now_ = step.span.end;
    }
    return seen && now_ && *now_ == time;
  }

  void setPose(const Pose2& pose) {
    start_ = pose;
    segment_ = MotionSegment();
  }
  /// Distance since is added up.
  Pose2 pose() const { return start_ * segment_.motion; }
  double distance() const { return segment_.distance; }

 private:
  const CalibrationDrive& drive_;
  MotionModel model_;
  MotionSegment segment_;
  Pose2 start_;
  std::size_t next_{0};
  std::optional<Time> now_;
};

}  // namespace

std::vector<ReckonedPose> deadReckon(const CalibrationDrive& drive, const Parameters& parameters,
                                     const ParameterVector& values, const std::vector<bool>& good) {
  const Pose2 from_laser = inverse(Pose2{values[kLaserX], values[kLaserY], values[kLaserYaw]});
  const Duration late = durationFromSeconds(values[kTimeOffset]);
  Reckoner reckoner(drive, parameters, values);
  std::vector<ReckonedPose> path;
  double before = 0.0;  // of the parts before this one
  bool interrupted = true;
  for (std::size_t i = 0; i < drive.lasers().size(); ++i) {
    const DriveLaser& laser = drive.lasers()[i];
    interrupted = !reckoner.moveTo(laser.laser.stamp - late) || interrupted || laser.jumped;
    if (!good[i]) continue;
    const Pose2 measured = laser.laser.pose * from_laser;
    if (interrupted) {
      before = path.empty() ? 0.0 : path.back().distance;
      reckoner.setPose(measured);
    }
    path.push_back({i, measured, reckoner.pose(), interrupted, before + reckoner.distance()});
    interrupted = false;
  }
  return path;
}

EndDrift endDriftOf(const std::vector<ReckonedPose>& path) {
  EndDrift drift;
  for (std::size_t i = 0; i < path.size(); ++i)
    if (i + 1 == path.size() || path[i + 1].begins)
      drift.error += (path[i].reckoned.position() - path[i].measured.position()).norm();
  if (!path.empty()) drift.distance = path.back().distance;
  return drift;
}

}  // namespace bs_car_odometry::tools
