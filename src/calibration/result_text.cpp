#include "result_text.hpp"

#include "bs_car_odometry/calibration/result_file.hpp"
#include "bs_car_odometry/parameters/load.hpp"

#include <boost/crc.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <limits>
#include <locale>
#include <set>
#include <sstream>
#include <vector>

namespace bs_car_odometry::calibration {

std::uint32_t crc32(const char* text, std::size_t size) {
  boost::crc_32_type crc;
  crc.process_bytes(text, size);
  return crc.checksum();
}

std::string checksumLine(const char* text, std::size_t size) {
  char line[32];
  std::snprintf(line, sizeof line, "%s%08x\n", kChecksumKey, static_cast<unsigned>(crc32(text, size)));
  return line;
}

Place placeOf(std::size_t parameter) {
  const std::string name = parameterName(parameter);
  const std::size_t slash = name.find('/');
  const std::string first = name.substr(0, slash);
  const std::string rest = name.substr(slash + 1);
  const std::string steering = "steering_";
  if (first == "laser") return {"laser", "", rest};
  if (rest.compare(0, steering.size(), steering) == 0)
    return {"steering", first, rest.substr(steering.size())};
  return {"gains", first, rest};
}

namespace {

/// File names in a calibration file take no more room than this.
constexpr std::size_t kMostForNames = 32768;

std::string digits(double value, int count) {
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  stream.precision(count);
  stream << value;
  return stream.str();
}

/// The fewest digits that read back as the same number, with a point, without which some readers take 1e-05
/// for a text.
std::string numberText(double value) {
  std::string text;
  for (int count = 6; count <= std::numeric_limits<double>::max_digits10; ++count) {
    text = digits(value, count);
    double back = 0.0;
    std::istringstream stream(text);
    stream.imbue(std::locale::classic());
    stream >> back;
    if (back == value) break;
  }
  if (text.find('.') != std::string::npos) return text;
  const std::size_t exponent = std::min(text.find('e'), text.size());
  return text.insert(exponent, ".0");
}

/// Plain where every YAML reader takes the name for a text.
bool isPlain(const std::string& name) {
  static const std::set<std::string> kWords{"null", "true", "false", "yes", "no", "on", "off", "y", "n"};
  const auto letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
  if (name.empty() || !letter(name.front())) return false;
  std::string lower;
  for (const char c : name) {
    if (!letter(c) && (c < '0' || c > '9') && c != '_' && c != '-' && c != '.') return false;
    lower += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return kWords.count(lower) == 0;
}

/// What means something to YAML is escaped even in quotes, so that a reader can turn down all else that holds
/// it.
std::string nameText(const std::string& name) {
  if (isPlain(name)) return name;
  std::string text = "\"";
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool harmless =
        std::isalnum(byte) != 0 || byte >= 0x80 || std::string(" /._-+~:,@()=").find(c) != std::string::npos;
    char escaped[8];
    std::snprintf(escaped, sizeof escaped, "\\x%02x", static_cast<unsigned>(byte));
    text += harmless ? std::string(1, c) : escaped;
  }
  return text + "\"";
}

std::string listText(const std::vector<std::string>& entries) {
  std::string text;
  for (const std::string& entry : entries) text += (text.empty() ? "" : ", ") + entry;
  return "[" + text + "]";
}

std::string numbersText(const std::vector<double>& numbers) {
  std::vector<std::string> texts;
  std::transform(numbers.begin(), numbers.end(), std::back_inserter(texts), numberText);
  return listText(texts);
}

std::string axlesText(const PerAxle<double>& values) {
  return "{front: " + numberText(values.front) + ", rear: " + numberText(values.rear) + "}";
}

/// The first ones that have room, and how many there are besides.
std::string bagsText(const std::vector<std::string>& bags) {
  std::vector<std::string> names;
  std::size_t size = 0;
  for (const std::string& bag : bags) {
    names.push_back(nameText(bag));
    size += names.back().size();
    if (size <= kMostForNames) continue;
    names.back() = nameText("and " + std::to_string(bags.size() - names.size() + 1) + " more");
    break;
  }
  return listText(names);
}

std::string dataLine(const DataUsed& data, const Parameters& parameters) {
  return "data: {bags: " + bagsText(data.bags) + ", from: " + numberText(data.from) +
         ", to: " + numberText(data.to) + ", distance: " + numberText(data.distance) +
         ", laser_poses: " + std::to_string(data.laser_poses) +
         ", rejected: " + std::to_string(data.rejected) +
         ", method: " + parameterWord(parameters, "calibration/method") +
         (data.objective.empty() ? "" : ", objective: " + data.objective) +
         ", axles: " + parameterWord(parameters, "odometry/axles") + "}\n";
}

/// "k_r: 1.0021, k_l: 0.9987", the listed values of a group; empty when there is none.
std::string valuesText(const CalibrationResult& result, const std::string& group, const std::string& axle) {
  std::string text;
  for (std::size_t i = 0; i < kCount; ++i) {
    const Place place = placeOf(i);
    if (!result.listed[i] || place.group != group || place.axle != axle) continue;
    text += (text.empty() ? "" : ", ") + place.key + ": " +
            numberText(result.values[static_cast<Eigen::Index>(i)]);
  }
  return text;
}

std::string gainsBlock(const CalibrationResult& result) {
  std::string text = "gains:\n";
  for (const char* axle : {"front", "rear"}) {
    const std::string values = valuesText(result, "gains", axle);
    if (!values.empty()) text += std::string("  ") + axle + ": {" + values + "}\n";
  }
  std::vector<std::string> names;
  std::vector<double> covariance;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (!result.listed[i]) continue;
    names.push_back(parameterName(i));
    for (std::size_t j = 0; j < kCount; ++j)
      if (result.listed[j])
        covariance.push_back(result.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
  }
  return text + "  parameters: " + listText(names) + "\n  covariance: " + numbersText(covariance) + "\n";
}

std::string steeringLine(const CalibrationResult& result) {
  std::string text;
  for (const char* axle : {"front", "rear"}) {
    const std::string values = valuesText(result, "steering", axle);
    if (!values.empty()) text += (text.empty() ? "" : ", ") + std::string(axle) + ": {" + values + "}";
  }
  return text.empty() ? "" : "steering: {" + text + "}\n";
}

std::string laserLine(const CalibrationResult& result) {
  const std::string values = valuesText(result, "laser", "");
  return values.empty() ? "" : "laser: {" + values + "}\n";
}

std::string notObservedLine(const CalibrationResult& result) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kCount; ++i)
    if (result.not_observed[i]) names.push_back(parameterName(i));
  return "not_observed: " + listText(names) + "\n";
}

}  // namespace

std::string vehicleLine(const Parameters& parameters) {
  const Vehicle& v = parameters.vehicle;
  std::string ticks;
  for (const Wheel wheel : kAllWheels)
    ticks +=
        (ticks.empty() ? "" : ", ") + std::string(name(wheel)) + ": " + numberText(v.metres_per_tick[wheel]);
  return "vehicle: {name: " + nameText(v.name) + ", wheelbase: " + numberText(v.wheelbase) +
         ", track: " + axlesText(v.track) + ", hub_offset: " + axlesText(v.hub_offset) +
         ", base_link_x: " + numberText(v.base_link_x) +
         ", axle_geometry: " + parameterWord(parameters, "vehicle/axle_geometry") +
         ", rear_steering: {source: " + parameterWord(parameters, "vehicle/rear_steering/source") +
         ", coefficients: " + numbersText(v.rear_steering.coefficients) + "}, metres_per_tick: {" + ticks +
         "}}";
}

std::uint32_t vehicleChecksum(const Parameters& parameters) {
  const std::string line = vehicleLine(parameters);
  return crc32(line.data(), line.size());
}

std::string toText(const CalibrationResult& result, const Parameters& parameters) {
  std::string text = "format: 1\nsoftware: " BS_CAR_ODOMETRY_VERSION "\n";
  text += vehicleLine(parameters) + "\n" + dataLine(result.data, parameters) + gainsBlock(result) +
          steeringLine(result) + laserLine(result) + notObservedLine(result);
  text += checksumLine(text.data(), text.size());
  fromText(text, parameters);  // Nothing is written that could not be read.
  return text;
}

}  // namespace bs_car_odometry::calibration
