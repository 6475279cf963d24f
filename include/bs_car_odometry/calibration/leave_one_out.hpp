#pragma once

#include "bs_car_odometry/calibration/refinement.hpp"

#include <vector>

namespace bs_car_odometry::calibration {

/// Dead reckoning over a drive against the laser. Where the localiser or the odometry was interrupted, each
/// part begins anew, and the errors at the ends of the parts add up.
struct Drift {
  double distance{0.0};  ///< [m]
  double error{0.0};     ///< [m], between the ends, both started at the laser's first pose
  double percent() const { return distance > 0.0 ? 100.0 * error / distance : 0.0; }
};

/// @param parameters  those that the drive was recorded with
/// @param values      for dead reckoning, laser mount and time offset included
/// @param residuals   of this drive, from any fit; poses beyond kRejectLimit neither begin nor end a part
Drift endDrift(const CalibrationDrive& drive, const Parameters& parameters, const ParameterVector& values,
               const std::vector<LaserResidual>& residuals);

/// What a calibration from the other drives is worth on one that it has not seen.
struct LeftOutDrive {
  Drift nominal;       ///< with the configured values
  Drift calibrated;    ///< with those of the other drives
  Drift all;           ///< with those of all drives, this one included
  Refinement refined;  ///< of the other drives, without its residuals
};

/// One for each drive; none where there is a single drive.
/// @param all  refinement of all of them, with which the others' begin
std::vector<LeftOutDrive> leaveOneOut(const Drives& drives, const Parameters& parameters,
                                      const Refinement& all, const RefinementOptions& options = {});

}  // namespace bs_car_odometry::calibration
