#pragma once

namespace bs_car_odometry::tools {

/// The tool `consistency`: published covariances against the truth of many simulated drives.
/// @throws InputError and what the parameters and the simulation throw
void consistency(int argc, const char* const* argv);

}  // namespace bs_car_odometry::tools
