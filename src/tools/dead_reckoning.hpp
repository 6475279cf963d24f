#pragma once

#include "bs_car_odometry/calibration/calibration_drive.hpp"
#include "bs_car_odometry/calibration/leave_one_out.hpp"
#include "bs_car_odometry/calibration/motion_model.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"

#include <cstddef>
#include <vector>

namespace bs_car_odometry::tools {

/// Goes through the steps of a drive, cut where laser poses are.
class DriveWalk {
 public:
  explicit DriveWalk(const calibration::CalibrationDrive& drive) : drive_(drive) {}

  /// Moves on to a time.
  /// @param visit  called with each step, or part of one, on the way
  /// @return false when motion on the way was not seen
  template <typename Visit>
  bool moveTo(Time time, const Visit& visit) {
    if (begun_ && time <= now_) return true;
    bool seen = true;
    for (; next_ < drive_.steps(); ++next_) {
      MeasuredStep step = drive_.step(next_);
      if (begun_ && step.span.begin > now_ && step.span.begin <= time) seen = false;
      if (step.span.begin >= time) break;
      if (begun_ && now_ > step.span.begin) step = calibration::split(step, now_).second;
      begun_ = true;
      if (step.span.end > time) {
        visit(calibration::split(step, time).first);
        now_ = time;
        return seen;
      }
      visit(step);
      now_ = step.span.end;
    }
    return seen && begun_ && now_ == time;
  }

 private:
  const calibration::CalibrationDrive& drive_;
  std::size_t next_{0};  ///< the step that was not gone through to its end
  bool begun_{false};    ///< a first step is behind
  Time now_;
};

/// Where the car was at a laser pose, by the laser and by dead reckoning.
struct ReckonedPose {
  std::size_t laser;  ///< its number in the drive
  Pose2 measured;     ///< base_link in the map, from the laser pose and the laser's mount
  Pose2 reckoned;     ///< base_link in the map
  bool begins;        ///< dead reckoning starts here, at the measured pose
  double distance;    ///< [m] since the drive's first one, without what was not seen
};

/// Dead reckoning over a drive with given values of the parameters, from its first good laser pose on. Where
/// the localiser has jumped or motion was not seen it begins anew.
/// @param parameters  those that the drive was recorded with
/// @param good        for each laser pose; others are passed over
std::vector<ReckonedPose> deadReckon(const calibration::CalibrationDrive& drive, const Parameters& parameters,
                                     const calibration::ParameterVector& values,
                                     const std::vector<bool>& good);

/// How far dead reckoning ends from the laser; the ends of parts add up.
calibration::Drift driftOf(const std::vector<ReckonedPose>& path);

}  // namespace bs_car_odometry::tools
