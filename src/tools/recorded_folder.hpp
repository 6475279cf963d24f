#pragma once

#include "noise_fit.hpp"

#include <map>
#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// How the runs of a folder are read; an entry of a file like test/evaluation/recordings.yaml:
///     optiodom_diff:
///       vehicle: vehicles/optiodom_diff.yaml       # from the file's folder
///       csv_to_bag: [--wheel-unit, tick_increments]
///       wheels:                                    # runs whose wheels were others than those of the rest
///         june: ["square-230620*", "circular-250620*"]
struct RecordedFolderSettings {
  std::string vehicle;                                     ///< path of the vehicle's file; may be empty
  std::vector<std::string> csv_to_bag;                     ///< options of csv_to_bag: units
  std::map<std::string, std::vector<std::string>> wheels;  ///< name -> patterns of run names, as a shell's
};

/// The entry `set` of a file.
/// @throws InputError
RecordedFolderSettings readRecordedFolderSettings(const std::string& file, const std::string& set);

/// Every sub-folder with wheels.csv and pose.csv (and steering.csv), in the order of their names. A run
/// called `path-recording-number` belongs to the recording `path-recording`.
/// @throws InputError when there is none
std::vector<RecordedRun> readRecordedFolder(const std::string& folder,
                                            const RecordedFolderSettings& settings);

}  // namespace bs_car_odometry::tools
