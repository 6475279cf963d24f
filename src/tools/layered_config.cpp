#include "layered_config.hpp"

#include "bs_car_odometry/parameters/load.hpp"
#include "tool.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>

namespace bs_car_odometry::tools {

namespace {

/// The value of a parameter may be a map itself: a distribution.
bool isParameter(const std::string& path) {
  static const std::vector<std::string> kPaths = parameterPaths();
  return std::find(kPaths.begin(), kPaths.end(), path) != kPaths.end();
}

/// Adds the values of a tree as settings, "path=value".
void flatten(const YAML::Node& node, const std::string& path, std::vector<std::string>& settings) {
  if (!node.IsMap() || isParameter(path)) {
    YAML::Emitter value;
    value << YAML::Flow << node;
    settings.push_back(path + "=" + value.c_str());
    return;
  }
  for (const auto& entry : node)
    flatten(entry.second, (path.empty() ? "" : path + "/") + entry.first.as<std::string>(), settings);
}

std::vector<std::string> settingsOf(const std::string& file) {
  std::vector<std::string> settings;
  try {
    const YAML::Node tree = YAML::LoadFile(file);
    if (!tree.IsMap()) throw InputError(file + ": is not a map of names and values");
    flatten(tree, "", settings);
  } catch (const YAML::BadFile&) {
    throw InputError(file + " cannot be read");
  } catch (const YAML::Exception& error) {
    throw InputError(file + ": " + error.what());
  }
  return settings;
}

}  // namespace

Parameters loadLayered(const std::vector<std::string>& configs, const std::vector<std::string>& settings) {
  std::vector<std::string> all;
  for (std::size_t i = 1; i < configs.size(); ++i)
    for (const std::string& setting : settingsOf(configs[i])) all.push_back(setting);
  all.insert(all.end(), settings.begin(), settings.end());
  return loadVehicle(configs.front(), all);
}

}  // namespace bs_car_odometry::tools
