#pragma once

#include <initializer_list>
#include <set>
#include <string>
#include <vector>

namespace bs_car_odometry::schema {

/// Collects everything that is wrong or doubtful about a set of parameters, so that one message can list it.
class Report {
 public:
  /// "path: value what; allowed: allowed", as in "noise/wheel: '-1' is out of range; allowed: ...".
  void problem(const std::string& path, const std::string& value, const std::string& what,
               const std::string& allowed);
  void warning(const std::string& text) { warnings_.push_back(text); }

  /// True when none of these has a problem: a rule between parameters is not judged on wrong ones.
  bool accepted(std::initializer_list<std::string> paths) const;

  const std::vector<std::string>& warnings() const { return warnings_; }

  /// @throws ParameterError when there is any problem
  void throwProblems() const;

 private:
  std::vector<std::string> problems_;
  std::set<std::string> paths_with_problems_;
  std::vector<std::string> warnings_;
};

/// A value as messages show it: short, printable and in quotes.
std::string quoted(const std::string& value);

/// A number as messages show it.
std::string numberText(double value);

}  // namespace bs_car_odometry::schema
