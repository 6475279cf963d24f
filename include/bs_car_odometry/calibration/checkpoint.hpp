#pragma once

#include "bs_car_odometry/calibration/calibrator.hpp"

#include <optional>
#include <string>

namespace bs_car_odometry::calibration {

/// A checkpoint older than this is of another drive [s].
constexpr double kOldestCheckpoint = 3600.0;

/// The file beside a calibration's `output` that keeps what a running calibration knows.
std::string checkpointPath(const std::string& output);

/// Writes a checkpoint; afterwards the file is the new one, or the one before.
/// @param now  [s] wall time
/// @throws FileError
void writeCheckpoint(const std::string& path, const CalibrationMemory& memory, const Parameters& parameters,
                     double now);

/// @return none where there is no file
/// @throws FileError with one sentence when it is damaged, too old, or of another car or other parameters
std::optional<CalibrationMemory> readCheckpoint(const std::string& path, const Parameters& parameters,
                                                double now);

/// No more to go on from.
void removeCheckpoint(const std::string& path);

}  // namespace bs_car_odometry::calibration
