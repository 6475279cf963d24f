#include "report.hpp"

#include "bs_car_odometry/parameters/load.hpp"

#include <sstream>

namespace bs_car_odometry::schema {

void Report::problem(const std::string& path, const std::string& value, const std::string& what,
                     const std::string& allowed) {
  const std::string shown = value.empty() ? what : value + " " + what;
  problems_.push_back(path + ": " + shown + "; allowed: " + allowed);
  paths_with_problems_.insert(path);
}

bool Report::accepted(std::initializer_list<std::string> paths) const {
  for (const std::string& path : paths)
    if (paths_with_problems_.count(path) > 0) return false;
  return true;
}

void Report::throwProblems() const {
  if (problems_.empty()) return;
  std::string message;
  for (const std::string& problem : problems_) message += (message.empty() ? "" : "\n") + problem;
  throw ParameterError(message);
}

std::string quoted(const std::string& value) {
  constexpr std::size_t kLongest = 60;
  std::string shown = value.size() > kLongest ? value.substr(0, kLongest) + "..." : value;
  for (char& c : shown)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  return "'" + shown + "'";
}

std::string numberText(double value) {
  std::ostringstream text;
  text.precision(10);
  text << value;
  return text.str();
}

}  // namespace bs_car_odometry::schema
