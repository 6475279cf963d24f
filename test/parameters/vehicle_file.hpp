#pragma once

#include "bs_car_odometry/parameters/load.hpp"
#include "tools/temporary_folder.hpp"

#include <string>
#include <utility>
#include <vector>

namespace bs_car_odometry::testing {

/// The least that a vehicle file must hold.
inline const char* const kMinimalVehicle =
    "vehicle: {wheelbase: 1.2, track: {front: 1.2, rear: 1.2}}\n"
    "encoders: {metres_per_tick: {front_left: 1.0e-4, front_right: 1.0e-4, rear_left: 1.0e-4, rear_right: "
    "1.0e-4}}\n";

/// A file with this text, removed at the end of its scope.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text) : path_(folder_.write("vehicle.yaml", text)) {}
  const std::string& path() const { return path_; }

 private:
  tools::testing::TemporaryFolder folder_;
  std::string path_;
};

using Overrides = std::vector<std::pair<std::string, std::string>>;

/// Loads a vehicle file of this text with `--set` overrides.
inline LoadedParameters load(const std::string& text, const Overrides& overrides = {}) {
  const TemporaryFile file(text);
  return loadParameters(loadParameterFiles({file.path()}, overrides));
}

/// The message that loading ends with; empty when it succeeds.
inline std::string errorOf(const std::string& text, const Overrides& overrides = {}) {
  try {
    load(text, overrides);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "";
}

}  // namespace bs_car_odometry::testing
