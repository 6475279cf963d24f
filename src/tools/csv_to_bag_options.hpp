#pragma once

#include "csv_recording.hpp"
#include "tool.hpp"

#include <string>

namespace bs_car_odometry::tools {

/// What the command line of csv_to_bag asks for.
struct CsvToBagOptions {
  CsvSource source;
  TopicNames topics;
  std::string output;
};

/// `--help` prints the usage and ends the process with 0.
/// @throws InputError
CsvToBagOptions csvToBagOptions(int argc, const char* const* argv);

}  // namespace bs_car_odometry::tools
