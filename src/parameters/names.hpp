#pragma once

#include "entry.hpp"
#include "report.hpp"

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

namespace bs_car_odometry::schema {

/// The parts of a path: "vehicle/track/front" has three.
std::vector<std::string> split(const std::string& path);

/// The one of `words`, at least one, that is most like `word`: the fewest letters to change.
std::string nearestWord(const std::vector<std::string>& words, const std::string& word);

/// Which paths are parameters, which are groups of them, and which known name an unknown one resembles.
class Names {
 public:
  explicit Names(const Schema& schema);

  bool isParameter(const std::string& path) const;

  /// True for the groups: "vehicle", "vehicle/track".
  bool isGroup(const std::string& path) const;

  /// True for the groups that a single value may stand for: "vehicle/track".
  bool isAxlePair(const std::string& path) const;

  /// The known path most like `path`: the fewest letters to change, either in the whole or in the last part,
  /// so that a name in the wrong group is found as well.
  std::string nearest(const std::string& path) const;

  /// Warns of the unknown names in a tree; groups that are no map, and names given twice, are problems.
  void check(const YAML::Node& tree, Report& report) const;

 private:
  void checkGroup(const YAML::Node& map, const std::string& group, Report& report) const;
  void checkChild(const YAML::Node& value, const std::string& path, Report& report) const;

  std::vector<std::string> parameters_;
  std::vector<std::string> groups_;
  std::vector<std::string> axle_pairs_;
};

}  // namespace bs_car_odometry::schema
