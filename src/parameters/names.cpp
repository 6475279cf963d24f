#include "names.hpp"

#include "edit_distance.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace bs_car_odometry::schema {
namespace {

/// What roslaunch, nodelet and diagnostic_updater keep among a node's private parameters.
const std::set<std::string> kOfOthers{"diagnostic_period", "diagnostic_updater_use_fqn", "num_worker_threads",
                                      "tf_prefix"};

bool contains(const std::vector<std::string>& paths, const std::string& path) {
  return std::find(paths.begin(), paths.end(), path) != paths.end();
}

}  // namespace

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t slash = path.find('/'); slash != std::string::npos; slash = path.find('/', begin)) {
    parts.push_back(path.substr(begin, slash - begin));
    begin = slash + 1;
  }
  parts.push_back(path.substr(begin));
  return parts;
}

std::string nearestWord(const std::vector<std::string>& words, const std::string& word) {
  return *std::min_element(words.begin(), words.end(), [&](const std::string& a, const std::string& b) {
    return editDistance(a, word) < editDistance(b, word);
  });
}

Names::Names(const Schema& schema) {
  for (const Entry& entry : schema) {
    parameters_.push_back(entry.path);
    for (std::size_t slash = entry.path.find('/'); slash != std::string::npos;
         slash = entry.path.find('/', slash + 1)) {
      const std::string group = entry.path.substr(0, slash);
      if (!contains(groups_, group)) groups_.push_back(group);
    }
    if (entry.one_for_both_axles) axle_pairs_.push_back(entry.path.substr(0, entry.path.rfind('/')));
  }
}

bool Names::isParameter(const std::string& path) const { return contains(parameters_, path); }
bool Names::isGroup(const std::string& path) const { return contains(groups_, path); }
bool Names::isAxlePair(const std::string& path) const { return contains(axle_pairs_, path); }

std::string Names::nearest(const std::string& path) const {
  std::string nearest;
  std::pair<std::size_t, std::size_t> least{std::string::npos, std::string::npos};
  for (const std::vector<std::string>* paths : {&parameters_, &groups_}) {
    for (const std::string& candidate : *paths) {
      const auto distance = pathDistance(path, candidate);
      if (distance >= least) continue;
      least = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

void Names::check(const YAML::Node& tree, Report& report) const { checkGroup(tree, "", report); }

void Names::checkGroup(const YAML::Node& map, const std::string& group, Report& report) const {
  const std::string prefix = group.empty() ? "" : group + "/";
  std::set<std::string> seen;
  for (const auto& child : map) {
    const std::string name = child.first.IsScalar() ? child.first.Scalar() : valueText(child.first);
    const std::string path = prefix + name;
    if (!seen.insert(name).second) report.problem(path, "", "is given twice", "once");
    checkChild(child.second, path, report);
  }
}

void Names::checkChild(const YAML::Node& value, const std::string& path, Report& report) const {
  if (isParameter(path) || kOfOthers.count(path) > 0) return;
  if (!isGroup(path)) {
    report.warning(path + ": unknown parameter, not used; the nearest known one is " + nearest(path));
  } else if (value.IsMap()) {
    checkGroup(value, path, report);
  } else if (!value.IsNull() && !(value.IsScalar() && isAxlePair(path))) {
    report.problem(path, valueText(value), "is not a map", "a map of the parameters in " + path);
  }
}

}  // namespace bs_car_odometry::schema
