#pragma once

namespace bs_car_odometry::tools {

/// The tool `simulate`: a recorded drive of the simulated car.
/// @throws InputError and what the parameters and the simulation throw
void simulate(int argc, const char* const* argv);

}  // namespace bs_car_odometry::tools
