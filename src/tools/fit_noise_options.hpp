#pragma once

#include "noise_fit.hpp"

#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// A bag with where it belongs.
struct NoiseBag {
  std::string path;
  std::string wheels;
  std::string recording;
};

/// What the command line of fit_noise asks for.
struct FitNoiseOptions {
  std::vector<NoiseBag> bags;
  Parameters parameters;
  TopicNames topics;
  NoiseFitSettings settings;
  std::string output;
};

/// `--help` prints the usage and ends the process with 0.
/// @throws InputError, ParameterError
FitNoiseOptions fitNoiseOptions(int argc, const char* const* argv);

/// Bags of a file that says which wheels and which recording they belong to: wheels -> recording -> bags,
/// paths from the file's folder.
/// @throws InputError
std::vector<NoiseBag> readRunsFile(const std::string& path);

}  // namespace bs_car_odometry::tools
