#include "recorded_folder.hpp"

#include "csv_to_bag_options.hpp"

#include <fnmatch.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>

namespace bs_car_odometry::tools {

namespace {

namespace fs = std::filesystem;

RecordedFolderSettings settingsOf(const YAML::Node& entry, const fs::path& folder) {
  RecordedFolderSettings settings;
  if (const YAML::Node vehicle = entry["vehicle"]) settings.vehicle = folder / vehicle.as<std::string>();
  if (const YAML::Node options = entry["csv_to_bag"])
    settings.csv_to_bag = options.as<std::vector<std::string>>();
  if (const YAML::Node wheels = entry["wheels"])
    settings.wheels = wheels.as<std::map<std::string, std::vector<std::string>>>();
  return settings;
}

/// Folders of runs, by name.
std::vector<fs::path> runFolders(const std::string& folder) {
  std::vector<fs::path> folders;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (fs::exists(entry.path() / "wheels.csv") && fs::exists(entry.path() / "pose.csv"))
      folders.push_back(entry.path());
  if (error) throw InputError(folder + " cannot be read: " + error.message());
  if (folders.empty())
    throw InputError(folder + " holds no runs: folders with a wheels.csv and a pose.csv each");
  std::sort(folders.begin(), folders.end());
  return folders;
}

CsvSource sourceOf(const fs::path& run, const std::vector<std::string>& options) {
  std::vector<std::string> words{"csv_to_bag", "--wheels", run / "wheels.csv", "--pose", run / "pose.csv",
                                 "--output",   "unused"};
  if (fs::exists(run / "steering.csv")) words.insert(words.end(), {"--steering", run / "steering.csv"});
  words.insert(words.end(), options.begin(), options.end());
  std::vector<const char*> argv;
  argv.reserve(words.size());
  for (const std::string& word : words) argv.push_back(word.c_str());
  return csvToBagOptions(static_cast<int>(argv.size()), argv.data()).source;
}

std::string wheelsOf(const std::string& run, const RecordedFolderSettings& settings) {
  for (const auto& [name, patterns] : settings.wheels)
    for (const std::string& pattern : patterns)
      if (::fnmatch(pattern.c_str(), run.c_str(), 0) == 0) return name;
  return "";
}

}  // namespace

RecordedFolderSettings readRecordedFolderSettings(const std::string& file, const std::string& set) {
  try {
    const YAML::Node entry = YAML::LoadFile(file)[set];
    if (!entry || !entry.IsMap()) throw InputError(file + " has no entry '" + set + "'");
    return settingsOf(entry, fs::path(file).parent_path());
  } catch (const YAML::Exception& error) {
    throw InputError(file + ": " + error.what());
  }
}

std::vector<RecordedRun> readRecordedFolder(const std::string& folder,
                                            const RecordedFolderSettings& settings) {
  std::vector<RecordedRun> runs;
  for (const fs::path& path : runFolders(folder)) {
    const std::string name = path.filename();
    const Recording recording = readRecording(sourceOf(path, settings.csv_to_bag));
    runs.push_back({makeDrive(name, recording), wheelsOf(name, settings), name.substr(0, name.rfind('-'))});
  }
  return runs;
}

}  // namespace bs_car_odometry::tools
