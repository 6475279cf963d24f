#pragma once

#include "noise_unknowns.hpp"
#include "recorded_drive.hpp"
#include "variance_components.hpp"

namespace bs_car_odometry::tools {

/// How a drive is compared with its truth.
struct ErrorSettings {
  double truth_position{0.02};  ///< [m], standard deviation of a true pose in x and in y
  double truth_yaw{0.005};      ///< [rad]
  bool headings{false};         ///< compare headings too, not positions alone
  double spacing{1.0};          ///< [m] between the places of comparison
  int most_places{40};          ///< of a drive; farther apart on a long one
};

/// Errors of one drive that begins at its first true pose; all in the frame of the tracked point there.
struct DriveErrors {
  LinearDrive path;  ///< at places along the drive, its end among them: x, y (and yaw) of each
  LinearDrive end;   ///< x, y, yaw at the end, noise of the truth included
  Pose2 odometry;    ///< at the end
  Pose2 truth;
  double distance{0.0};  ///< [m], mean of the wheels' travels
};

/// Drives the car again with the parameters given, through the code of the nodelet, and again with each
/// unknown a little changed: the published poses and covariances give sensitivities and components of noise,
/// whatever the car (docs/model.md, R1).
/// @throws InputError when odometry and truth do not overlap
DriveErrors driveErrors(const RecordedDrive& drive, const Parameters& parameters,
                        const NoiseUnknowns& unknowns, const ErrorSettings& settings);

}  // namespace bs_car_odometry::tools
