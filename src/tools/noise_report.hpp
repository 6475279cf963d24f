#pragma once

#include "noise_fit.hpp"

#include <string>

namespace bs_car_odometry::tools {

/// For a reader: what was found, with standard deviations.
std::string noiseTable(const NoiseFit& fit);

/// A YAML file to load on top of the vehicle's: the noise, NoiseFit::next_drive, and the gains (with several
/// sets of wheels only in comments).
std::string noiseYaml(const NoiseFit& fit);

}  // namespace bs_car_odometry::tools
