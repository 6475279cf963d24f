#include "bs_car_odometry/parameters/load.hpp"

#include "names.hpp"
#include "schema.hpp"

#include <fstream>
#include <iterator>

namespace bs_car_odometry {
namespace {

using schema::Entry;
using schema::Names;
using schema::Report;

/// A vehicle file has some 4 kB; more is a mistake such as a bag in its place.
constexpr std::size_t kLargestFile = 65536;

/// The node at `parts[depth]...` below `node`, undefined where there is none.
YAML::Node find(const YAML::Node& node, const std::vector<std::string>& parts, std::size_t depth,
                bool one_for_both_axles) {
  if (depth == parts.size()) return node;
  if (node.IsScalar() && one_for_both_axles && depth + 1 == parts.size()) return node;
  if (!node.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
  const YAML::Node child = node[parts[depth]];
  if (!child.IsDefined()) return YAML::Node(YAML::NodeType::Undefined);
  return find(child, parts, depth + 1, one_for_both_axles);
}

void readEntry(const YAML::Node& tree, const Entry& entry, Report& report) {
  const YAML::Node node = find(tree, schema::split(entry.path), 0, entry.one_for_both_axles);
  if (node.IsDefined()) {
    const schema::Fault fault = entry.read(node);
    if (!fault.key.empty()) {
      report.problem(entry.path + "/" + fault.key, fault.value, fault.what, fault.allowed);
    } else if (!fault.what.empty()) {
      report.problem(entry.path, schema::valueText(node), fault.what, entry.allowed);
    }
  } else if (entry.required) {
    report.problem(entry.path, "", "is missing", entry.allowed);
  }
}

std::string readFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw ParameterError(path + ": cannot be opened");
  std::string text(kLargestFile + 1, '\0');
  file.read(&text[0], static_cast<std::streamsize>(text.size()));
  if (file.bad() || (file.fail() && !file.eof())) throw ParameterError(path + ": cannot be read");
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kLargestFile) throw ParameterError(path + ": is larger than 64 kB, no parameter file");
  return text;
}

YAML::Node parse(const std::string& text, const std::string& source) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw ParameterError(source + ": not YAML: " + error.what());
  }
}

/// The map below `parent` under `key`, made where there is none. A single value for both axles becomes a map
/// first, so that one axle can be set.
YAML::Node childMap(YAML::Node parent, const std::string& key, bool is_axle_pair) {
  const YAML::Node child = parent[key];
  if (child.IsDefined() && child.IsMap()) return child;
  YAML::Node map(YAML::NodeType::Map);
  if (child.IsDefined() && child.IsScalar() && is_axle_pair) {
    map["front"] = child.Scalar();
    map["rear"] = child.Scalar();
  }
  parent[key] = map;
  return map;
}

void apply(const std::string& path, const YAML::Node& value, const Names& names, YAML::Node& tree) {
  const std::vector<std::string> parts = schema::split(path);
  YAML::Node node = tree;
  std::string group;
  for (std::size_t i = 0; i + 1 < parts.size(); ++i) {
    group += (i == 0 ? "" : "/") + parts[i];
    node.reset(childMap(node, parts[i], names.isAxlePair(group)));
  }
  node[parts.back()] = value;
}

/// Values by the paths of their parameters.
using Values = std::vector<std::pair<std::string, YAML::Node>>;

/// What stands in a tree. The value of a parameter may be a map itself: a distribution.
void collect(const YAML::Node& node, const std::string& path, const Names& names, Values& values) {
  if (node.IsNull() && !names.isParameter(path)) return;  // a group without contents
  if (!node.IsMap() || names.isParameter(path)) {
    values.emplace_back(path, node);
    return;
  }
  for (const auto& child : node)
    collect(child.second, (path.empty() ? "" : path + "/") + child.first.Scalar(), names, values);
}

void applyValues(const Values& values, const Names& names, YAML::Node& tree) {
  Report report;
  for (const auto& [path, value] : values) {
    if (names.isParameter(path) || names.isGroup(path)) {
      apply(path, value, names, tree);
    } else {
      report.problem(path, schema::valueText(value), "is set, but no such parameter is known",
                     "a known name; the nearest is " + names.nearest(path));
    }
  }
  report.throwProblems();
}

YAML::Node readTree(const std::string& path) {
  YAML::Node tree = parse(readFile(path), path);
  if (!tree.IsDefined() || tree.IsNull()) throw ParameterError(path + ": is empty");
  if (!tree.IsMap()) throw ParameterError(path + ": is not a map of names and values");
  return tree;
}

LoadedParameters load(const YAML::Node& tree) {
  LoadedParameters loaded;
  const schema::Schema entries = schema::parameterSchema(loaded.parameters);
  Report report;
  Names(entries).check(tree, report);
  for (const Entry& entry : entries) readEntry(tree, entry, report);
  schema::stripLeadingSlashes(loaded.parameters, report);
  schema::checkRules(loaded.parameters, report);
  report.throwProblems();
  loaded.warnings = report.warnings();
  return loaded;
}

Entry entryOf(Parameters& parameters, const std::string& path) {
  for (const Entry& entry : schema::parameterSchema(parameters))
    if (entry.path == path) return entry;
  throw ParameterError(path + ": no such parameter");
}

}  // namespace

LoadedParameters loadParameters(const YAML::Node& tree) {
  try {
    if (tree.IsDefined() && !tree.IsNull() && !tree.IsMap())
      throw ParameterError("the parameters: " + schema::valueText(tree) +
                           " is not a map of names and values");
    return load(tree.IsDefined() ? tree : YAML::Node());
  } catch (const YAML::Exception& error) {
    throw ParameterError(std::string("the parameters cannot be read: ") + error.what());
  }
}

YAML::Node loadParameterFiles(const std::vector<std::string>& paths,
                              const std::vector<std::pair<std::string, std::string>>& overrides) {
  YAML::Node tree = readTree(paths.at(0));
  Parameters parameters;
  const Names names(schema::parameterSchema(parameters));
  Values values;
  for (std::size_t i = 1; i < paths.size(); ++i) collect(readTree(paths[i]), "", names, values);
  for (const auto& [path, value] : overrides) values.emplace_back(path, parse(value, path));
  applyValues(values, names, tree);
  return tree;
}

std::vector<std::string> parameterPaths() {
  Parameters parameters;
  std::vector<std::string> paths;
  for (const Entry& entry : schema::parameterSchema(parameters)) paths.push_back(entry.path);
  return paths;
}

std::vector<std::string> parameterWords(const std::string& path) {
  Parameters parameters;
  return entryOf(parameters, path).words;
}

std::string parameterWord(Parameters parameters, const std::string& path) {
  const Entry entry = entryOf(parameters, path);
  return entry.word ? entry.word() : "";
}

}  // namespace bs_car_odometry
