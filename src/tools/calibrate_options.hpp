#pragma once

#include "tool.hpp"

#include "bs_car_odometry/calibration/refinement.hpp"

#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// What the command line of calibrate_bag asks for.
struct CalibrateOptions {
  std::vector<std::string> bags;
  Parameters parameters;
  TopicNames topics;
  std::string output;  ///< calibration file
  std::string report;  ///< folder; empty: no report
  bool pdf{false};     ///< the report as one file too
  bool refine{true};   ///< fit everything at once after the filter,
  calibration::Objective objective{calibration::Objective::kLikelihood};  ///< by this
  std::optional<double> distance;  ///< [m] length of the first bag by tape
};

/// `--help` prints the usage and ends the process with 0.
/// @throws InputError, ParameterError
CalibrateOptions calibrateOptions(int argc, const char* const* argv);

}  // namespace bs_car_odometry::tools
