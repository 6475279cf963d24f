#include "bs_car_odometry/calibration/result_file.hpp"
#include "bs_car_odometry/parameters/load.hpp"
#include "result_text.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <locale>
#include <map>
#include <optional>
#include <sstream>
#include <vector>

namespace bs_car_odometry::calibration {

namespace {

constexpr const char* kCalibrateAgain = "; calibrate again, or take a copy that is whole";

[[noreturn]] void refuse(const std::string& what) { throw CalibrationFileError(what); }

/// A text of the file in a message: short and printable.
std::string shown(const std::string& text) {
  constexpr std::size_t kMost = 40;
  std::string result = "'";
  for (const char c : text.substr(0, kMost)) result += c < 0x20 || c > 0x7e ? '?' : c;
  return result + (text.size() > kMost ? "...'" : "'");
}

/// The text without its last line, which must be the checksum of all before it.
std::string withoutChecksum(const std::string& text) {
  const std::size_t length = std::strlen(kChecksumKey) + 9;  // eight digits and a line break
  if (text.size() > kLargestFile) refuse("it is larger than 64 kB: no calibration file; check its name");
  if (text.size() < length ||
      text.compare(text.size() - length, std::strlen(kChecksumKey), kChecksumKey) != 0)
    refuse(std::string("its last line is no checksum: it was cut or altered, or is no calibration file") +
           kCalibrateAgain);
  const std::size_t size = text.size() - length;
  if (text.compare(size, length, checksumLine(text.data(), size)) != 0)
    refuse(std::string("its checksum does not match: it was cut or altered") + kCalibrateAgain);
  return text.substr(0, size);
}

/// What the YAML parser is spared: tags, aliases, block texts, and nesting, for which it takes stack without
/// limit. A calibration file needs none of them.
bool isSimpleYaml(const std::string& text) {
  constexpr std::ptrdiff_t kMostBrackets = 64;
  const auto forbidden = [](char c) {
    return (c >= 0 && c < 0x20 && c != '\n') || (c != '\0' && std::strchr("!&*|>%?`'\x7f", c) != nullptr);
  };
  if (std::any_of(text.begin(), text.end(), forbidden)) return false;
  const auto opens = [](char c) { return c == '[' || c == '{'; };
  if (std::count_if(text.begin(), text.end(), opens) > kMostBrackets) return false;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t dashes = line.find_first_not_of(" -");
    const std::size_t end = std::min(dashes, line.size());
    if (std::count(line.begin(), line.begin() + static_cast<std::ptrdiff_t>(end), '-') > 3) return false;
  }
  return true;
}

/// A map of the file: every key once, and no other keys than the known ones.
class Map {
 public:
  Map(const YAML::Node& node, std::string path, std::initializer_list<const char*> known)
      : path_(std::move(path)) {
    if (!node.IsMap()) refuse(where() + " is not a map of names and values" + kCalibrateAgain);
    for (const auto& child : node) {
      if (!child.first.IsScalar()) refuse(where() + " holds a key that is no name" + kCalibrateAgain);
      const std::string& key = child.first.Scalar();
      if (known.size() > 0 && std::find(known.begin(), known.end(), key) == known.end())
        refuse(pathOf(key) + " is unknown to this version; calibrate again with it");
      if (!children_.emplace(key, child.second).second)
        refuse(pathOf(key) + " is given twice" + kCalibrateAgain);
    }
  }

  bool has(const std::string& key) const { return children_.count(key) > 0; }
  bool isEmpty() const { return children_.empty(); }

  YAML::Node at(const std::string& key) const {
    const auto child = children_.find(key);
    if (child == children_.end()) refuse(pathOf(key) + " is missing" + kCalibrateAgain);
    return child->second;
  }

  Map map(const std::string& key, std::initializer_list<const char*> known) const {
    return Map(at(key), pathOf(key), known);
  }

  std::string text(const std::string& key) const { return textOf(at(key), pathOf(key)); }
  double number(const std::string& key) const { return numberOf(at(key), pathOf(key)); }

  std::vector<double> numbers(const std::string& key) const {
    std::vector<double> values;
    for (const YAML::Node& element : list(key)) values.push_back(numberOf(element, pathOf(key)));
    return values;
  }

  std::vector<std::string> texts(const std::string& key) const {
    std::vector<std::string> values;
    for (const YAML::Node& element : list(key)) values.push_back(textOf(element, pathOf(key)));
    return values;
  }

 private:
  std::string where() const { return path_.empty() ? "the whole" : path_; }
  std::string pathOf(const std::string& key) const {
    const std::string printable = shown(key);
    return (path_.empty() ? "" : path_ + "/") + printable.substr(1, printable.size() - 2);
  }

  YAML::Node list(const std::string& key) const {
    const YAML::Node node = at(key);
    if (!node.IsSequence()) refuse(pathOf(key) + " is not a list" + kCalibrateAgain);
    return node;
  }

  static std::string textOf(const YAML::Node& node, const std::string& path) {
    if (!node.IsScalar()) refuse(path + " is not a text" + kCalibrateAgain);
    return node.Scalar();
  }

  static double numberOf(const YAML::Node& node, const std::string& path) {
    std::istringstream stream(textOf(node, path));
    stream.imbue(std::locale::classic());
    double value = 0.0;
    stream >> std::noskipws >> value;
    if (stream.fail() || stream.peek() != std::istringstream::traits_type::eof() || !std::isfinite(value))
      refuse(path + " is not a finite number" + kCalibrateAgain);
    return value;
  }

  std::string path_;
  std::map<std::string, YAML::Node> children_;
};

/// Of an earlier one or of a later one, with other rules.
void checkFormat(const Map& file) {
  if (file.text("format") != "1")
    refuse("its format is " + shown(file.text("format")) +
           ", and this version reads 1; calibrate again with it");
  file.text("software");
}

class VehicleCheck {
 public:
  explicit VehicleCheck(const Map& map) : map_(map) {}

  void number(const Map& map, const std::string& key, double loaded, const std::string& name) const {
    if (map.number(key) != loaded) differ(name, map.text(key));
  }
  void text(const Map& map, const std::string& key, const std::string& loaded,
            const std::string& name) const {
    if (map.text(key) != loaded) differ(name, map.text(key));
  }
  void axles(const std::string& key, const PerAxle<double>& loaded) const {
    const Map axles = map_.map(key, {"front", "rear"});
    number(axles, "front", loaded.front, key + "/front");
    number(axles, "rear", loaded.rear, key + "/rear");
  }
  [[noreturn]] static void differ(const std::string& name, const std::string& value) {
    refuse(
        "it belongs to another car: its " + name + " is " + shown(value) +
        ", not that of the loaded configuration; calibrate this car, or load the file that was made for it");
  }

 private:
  const Map& map_;
};

/// Words and coefficients are compared as they would be written.
void checkVehicle(const Map& file, const Parameters& parameters) {
  const Vehicle& v = parameters.vehicle;
  const Map map = file.map("vehicle", {"name", "wheelbase", "track", "hub_offset", "base_link_x",
                                       "axle_geometry", "rear_steering", "metres_per_tick"});
  const VehicleCheck check(map);
  check.text(map, "name", v.name, "name");
  check.number(map, "wheelbase", v.wheelbase, "wheelbase");
  check.axles("track", v.track);
  check.axles("hub_offset", v.hub_offset);
  check.number(map, "base_link_x", v.base_link_x, "base_link_x");
  check.text(map, "axle_geometry", parameterWord(parameters, "vehicle/axle_geometry"), "axle_geometry");
  const Map rear = map.map("rear_steering", {"source", "coefficients"});
  check.text(rear, "source", parameterWord(parameters, "vehicle/rear_steering/source"),
             "rear_steering/source");
  if (rear.numbers("coefficients") != v.rear_steering.coefficients)
    VehicleCheck::differ("rear_steering/coefficients", "different");
  const Map ticks = map.map("metres_per_tick", {"front_left", "front_right", "rear_left", "rear_right"});
  for (const Wheel wheel : kAllWheels)
    check.number(ticks, name(wheel), v.metres_per_tick[wheel], std::string("metres_per_tick/") + name(wheel));
}

std::uint64_t countOf(const Map& map, const std::string& key) {
  const double value = map.number(key);
  if (!(value >= 0.0 && value < 1e15 && value == std::floor(value)))
    refuse("data/" + key + " is no count" + kCalibrateAgain);
  return static_cast<std::uint64_t>(value);
}

DataUsed readData(const Map& file) {
  const Map map = file.map("data", {});
  return {map.texts("bags"),      map.number("from"),          map.number("to"),
          map.number("distance"), countOf(map, "laser_poses"), countOf(map, "rejected")};
}

/// Parameters by their names, each once, in the order of the file.
std::vector<std::size_t> parametersOf(const std::vector<std::string>& names, const std::string& list) {
  std::vector<std::size_t> parameters;
  for (const std::string& name : names) {
    const std::optional<std::size_t> parameter = parameterNamed(name);
    if (!parameter) refuse(list + " holds " + shown(name) + ", which no calibration finds" + kCalibrateAgain);
    if (std::find(parameters.begin(), parameters.end(), *parameter) != parameters.end())
      refuse(list + " holds " + shown(name) + " twice" + kCalibrateAgain);
    parameters.push_back(*parameter);
  }
  return parameters;
}

/// Every number of the groups gains, steering and laser, by the names of the parameters.
class Values {
 public:
  explicit Values(const Map& file) {
    const Map gains = file.map("gains", {"front", "rear", "parameters", "covariance"});
    for (const char* axle : {"front", "rear"})
      if (gains.has(axle)) add(gains.map(axle, {"k_r", "k_l", "k_b"}), "gains", axle);
    if (file.has("steering")) {
      const Map steering = file.map("steering", {"front", "rear"});
      for (const char* axle : {"front", "rear"})
        if (steering.has(axle)) add(steering.map(axle, {"offset", "scale"}), "steering", axle);
    }
    if (file.has("laser")) add(file.map("laser", {"x", "y", "yaw", "time_offset"}), "laser", "");
  }

  /// A value that is listed without a covariance, or the reverse, would be believed too much.
  void check(const ParameterMask& listed) const {
    for (std::size_t i = 0; i < kCount; ++i) {
      if (listed[i] != values_[i].has_value())
        refuse(parameterName(i) +
               (listed[i] ? " is listed without a value" : " has a value, but is not listed") +
               kCalibrateAgain);
      const std::string fault = listed[i] ? faultOf(i, *values_[i]) : "";
      if (!fault.empty()) refuse(parameterName(i) + " " + fault + kCalibrateAgain);
    }
  }

  double operator[](std::size_t parameter) const { return *values_[parameter]; }

 private:
  void add(const Map& map, const std::string& group, const std::string& axle) {
    for (std::size_t i = 0; i < kCount; ++i) {
      const Place place = placeOf(i);
      if (place.group == group && place.axle == axle && map.has(place.key))
        values_[i] = map.number(place.key);
    }
  }

  std::array<std::optional<double>, kCount> values_;
};

void readCovariance(const std::vector<double>& numbers, const std::vector<std::size_t>& order,
                    ParameterMatrix& covariance) {
  if (numbers.size() != order.size() * order.size())
    refuse("gains/covariance has " + std::to_string(numbers.size()) + " numbers for " +
           std::to_string(order.size()) + " parameters" + kCalibrateAgain);
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t j = 0; j < order.size(); ++j)
      covariance(static_cast<Eigen::Index>(order[i]), static_cast<Eigen::Index>(order[j])) =
          numbers[i * order.size() + j];
  if (!isCovariance(covariance))
    refuse(std::string("gains/covariance is not symmetric and positive semidefinite") + kCalibrateAgain);
}

CalibrationResult read(const std::string& text, const Parameters& parameters) {
  const Map file(YAML::Load(text), "", {});
  checkFormat(file);
  checkVehicle(file, parameters);
  CalibrationResult result;
  result.data = readData(file);
  const Map gains = file.map("gains", {});
  const std::vector<std::size_t> order = parametersOf(gains.texts("parameters"), "gains/parameters");
  if (order.empty()) refuse("it holds no parameter that was observed; drive more, and calibrate again");
  for (const std::size_t parameter : order) result.listed[parameter] = true;
  const Values values(file);
  values.check(result.listed);
  for (const std::size_t i : order) result.values[static_cast<Eigen::Index>(i)] = values[i];
  readCovariance(gains.numbers("covariance"), order, result.covariance);
  for (const std::size_t i : parametersOf(file.texts("not_observed"), "not_observed")) {
    if (result.listed[i]) refuse(parameterName(i) + " is both observed and not" + kCalibrateAgain);
    result.not_observed[i] = true;
  }
  return result;
}

}  // namespace

CalibrationResult fromText(const std::string& text, const Parameters& parameters) {
  const std::string content = withoutChecksum(text);
  if (!isSimpleYaml(content)) refuse(std::string("it is no YAML as calibrations have it") + kCalibrateAgain);
  try {
    return read(content, parameters);
  } catch (const YAML::Exception&) {
    refuse(std::string("it is no YAML") + kCalibrateAgain);
  }
}

}  // namespace bs_car_odometry::calibration
