#pragma once

#include "bs_car_odometry/parameters/parameters.hpp"

#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// Parameters of the vehicle file `configs[0]`, with the values of the further files on top in their order
/// (a result of fit_noise, for instance) and the `settings` ("odometry/axles=rear") last.
/// @throws InputError, ParameterError; in the further files an unknown name is an error
Parameters loadLayered(const std::vector<std::string>& configs, const std::vector<std::string>& settings);

}  // namespace bs_car_odometry::tools
