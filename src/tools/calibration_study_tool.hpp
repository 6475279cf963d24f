#pragma once

namespace bs_car_odometry::tools {

/// A figure is not what is asked for.
constexpr int kTargetMissedStatus = 1;

/// The tool `calibration_study`: the calibration against its targets over many simulated drives.
/// @return true when all are met
/// @throws InputError and what the parameters and the simulation throw
bool calibrationStudy(int argc, const char* const* argv);

}  // namespace bs_car_odometry::tools
