#pragma once

#include "bs_car_odometry/parameters/parameters.hpp"

#include <functional>
#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// A constant of the car that is found along with the noise.
struct UnknownGain {
  std::string name;  ///< path of the parameter, "gains/rear/k_b"
  std::function<double&(Parameters&)> value;
  double prior;            ///< standard deviation before any drive
  std::string systematic;  ///< path of the parameter that says how it varies, "noise/systematic/k_b"
};

/// A standard deviation of `noise`.
struct UnknownNoise {
  std::string name;  ///< path of the parameter, "noise/wheel"
  std::function<Distribution&(NoiseModel&)> value;
  double least;  ///< where the search begins when the file says 0
};

/// What a fit looks for.
struct NoiseUnknowns {
  std::vector<UnknownGain> gains;
  std::vector<UnknownNoise> path;        ///< noise that is new in every step
  std::vector<UnknownNoise> systematic;  ///< spread of constant errors from recording to recording
};

/// Names that `names` of noiseUnknowns() may hold.
std::vector<std::string> noiseNames();

/// Gains of the used axles (and steering offsets, where `calibration/estimate` lists them), and the named
/// parameters of `noise`.
/// @throws InputError for a name that is not known, or a spread of something that is not looked for
NoiseUnknowns noiseUnknowns(const Parameters& parameters, const std::vector<std::string>& names);

}  // namespace bs_car_odometry::tools
