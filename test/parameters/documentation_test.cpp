// README.md's tables and the vehicle files agree with the parameters that the package knows.

#include "bs_car_odometry/parameters/load.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

namespace bs_car_odometry {
namespace {

/// The names in the first cell of a table's row: "| `a`, `b` | ..." has two.
void collectNames(const std::string& row, std::set<std::string>& names) {
  const std::string cell = row.substr(0, row.find('|', 1));
  std::size_t begin = cell.find('`');
  while (begin != std::string::npos) {
    const std::size_t end = cell.find('`', begin + 1);
    if (end == std::string::npos) return;
    names.insert(cell.substr(begin + 1, end - begin - 1));
    begin = cell.find('`', end + 1);
  }
}

/// The rows of the tables that begin "| `name` |"; none when there is no such file.
std::set<std::string> documentedNames(const std::string& file) {
  std::set<std::string> names;
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);)
    if (line.compare(0, 3, "| `") == 0) collectNames(line, names);
  return names;
}

TEST(Documentation, readmeNamesEveryParameter) {
  const std::set<std::string> names = documentedNames(BS_CAR_ODOMETRY_SOURCE "/README.md");
  for (const std::string& path : parameterPaths())
    EXPECT_EQ(names.count(path), 1u) << "README.md has no table row that begins | `" << path << "`";
}

TEST(Documentation, readmeNamesNoOtherParameter) {
  const std::vector<std::string> known = parameterPaths();
  for (const std::string& name : documentedNames(BS_CAR_ODOMETRY_SOURCE "/README.md")) {
    // What stands in a group can only be a parameter; topics of the tables have no slash inside.
    if (name.find('/', 1) == std::string::npos) continue;
    EXPECT_NE(std::find(known.begin(), known.end(), name), known.end()) << name << " in README.md";
  }
}

TEST(Documentation, theDistributionsOfTheInterfaceLoad) {
  std::ifstream lines(BS_CAR_ODOMETRY_SOURCE "/docs/interface.md");
  std::size_t examples = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.compare(0, 14, "{distribution:") != 0) continue;
    SCOPED_TRACE(line);
    ++examples;
    const LoadedParameters loaded = loadParameters(
        loadParameterFiles({BS_CAR_ODOMETRY_SOURCE "/config/cycab.yaml"}, {{"noise/wheel", line}}));
    EXPECT_GT(loaded.parameters.noise.wheel.std(), 0.0);
  }
  EXPECT_EQ(examples, 4u) << "one for each shape";
}

TEST(VehicleFiles, loadWithoutWarnings) {
  std::size_t files = 0;
  for (const auto& file : std::filesystem::directory_iterator(BS_CAR_ODOMETRY_SOURCE "/config")) {
    if (file.path().extension() != ".yaml") continue;
    SCOPED_TRACE(file.path().string());
    ++files;
    const LoadedParameters loaded = loadParameters(loadParameterFiles({file.path().string()}));
    for (const std::string& warning : loaded.warnings) ADD_FAILURE() << warning;
  }
  EXPECT_GT(files, 0u);
}

}  // namespace
}  // namespace bs_car_odometry
