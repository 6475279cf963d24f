#pragma once

#include "drive_record.hpp"

#include <optional>

namespace bs_car_odometry::tools::doctor {

struct LaserLag {
  double lag;    ///< [s] a pose stamped t shows the car at t - lag
  double sigma;  ///< [s] standard deviation
};

/// By how much the laser is late against the wheels: the shift of time with which turns and speed of the
/// laser are best explained by the wheels. Neither gains nor signs nor the order of the wheels matter, since
/// each wheel has a factor of its own in the fit.
/// @return none where the drive does not show it within +/-1 s: it neither speeds up nor turns, or is short
std::optional<LaserLag> estimateLaserLag(const DriveRecord& record);

}  // namespace bs_car_odometry::tools::doctor
