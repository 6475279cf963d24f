#pragma once

namespace bs_car_odometry::tools {

/// The tool `consistency --recorded`: published covariances against the truth of recorded drives.
/// @throws InputError and what the parameters throw
void recordedConsistency(int argc, const char* const* argv);

}  // namespace bs_car_odometry::tools
