#pragma once

#include "bs_car_odometry/core/distribution.hpp"
#include "bs_car_odometry/core/time.hpp"

#include <yaml-cpp/yaml.h>
#include <Eigen/Core>

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace bs_car_odometry::schema {

/// What is wrong with a value; nothing when `what` is empty.
struct Fault {
  Fault(std::string wrong = "") : what(std::move(wrong)) {}  // NOLINT: most faults are one text
  Fault(std::string key_of_map, std::string value_there, std::string wrong, std::string allowed_there)
      : what(std::move(wrong)),
        key(std::move(key_of_map)),
        value(std::move(value_there)),
        allowed(std::move(allowed_there)) {}

  std::string what;  ///< "is not a number"
  std::string
      key;  ///< where the value is a map: the key at fault, with what stands there and may stand there
  std::string value;    ///< in quotes
  std::string allowed;  ///< "a number from 0 to 1"
};

/// One parameter: where it stands in the YAML tree, what is allowed there, and how it reaches its struct.
struct Entry {
  std::string path;     ///< "vehicle/track/front"
  std::string allowed;  ///< for messages: "a number above 0, at most 100 [m]"

  /// Reads a node into the member of the struct; leaves the member alone when something is wrong.
  std::function<Fault(const YAML::Node&)> read;

  bool required{false};
  bool one_for_both_axles{false};  ///< a single value one level up ("vehicle/track: 1.2") serves both axles

  /// Where it takes one word out of several: all of them, and that of the struct's present value.
  std::vector<std::string> words{};
  std::function<std::string()> word{};
};

/// Parameters in the order of the documentation. Entries refer to the struct they were made for.
using Schema = std::vector<Entry>;

/// What a number must lie in.
struct Range {
  double low;
  double high;
  bool low_included;
  std::string unit;  ///< empty: none

  bool holds(double value) const { return (low_included ? value >= low : value > low) && value <= high; }
  std::string text() const;
};

/// low <= value <= high.
inline Range from(double low, double high, std::string unit = "") {
  return {low, high, true, std::move(unit)};
}
/// low < value <= high.
inline Range above(double low, double high, std::string unit = "") {
  return {low, high, false, std::move(unit)};
}

/// The words that a parameter knows, with their values.
template <typename Value>
struct Choices {
  std::vector<std::pair<std::string, Value>> words;
};

Entry number(const std::string& path, double& member, const Range& range);
/// A standard deviation in `range`, or a map such as {distribution: uniform, half_width: 0.01} that has one.
Entry distribution(const std::string& path, Distribution& member, const Range& range);
Entry nonZeroNumber(const std::string& path, double& member, const Range& range);
Entry seconds(const std::string& path, Duration& member, const Range& range);
Entry flag(const std::string& path, bool& member);
Entry text(const std::string& path, std::string& member, const std::string& allowed = "a text");

/// A whole number in [low, high].
Entry integer(const std::string& path, int& member, int low, int high);

/// 0, or a whole number in [low, high].
Entry zeroOrInteger(const std::string& path, int& member, int low, int high);

/// A list of `fewest` to `most` numbers, each in [-limit, limit].
Entry numbers(const std::string& path, std::vector<double>& member, std::size_t fewest, std::size_t most,
              double limit);

/// A list of at most `most` texts; a single text is a list of one, or of none when it is empty.
Entry texts(const std::string& path, std::vector<std::string>& member, std::size_t most,
            const std::string& allowed);

/// A list of different words out of `words`, at least one.
Entry subset(const std::string& path, std::vector<std::string>& member,
             const std::vector<std::string>& words);

/// Nine numbers, row by row: a symmetric positive semidefinite matrix.
Entry covariance(const std::string& path, Eigen::Matrix3d& member);

Entry required(Entry entry);
Entry oneForBothAxles(Entry entry);

/// The node's text, on one line and short enough for a message.
std::string valueText(const YAML::Node& node);

namespace detail {
std::string wordsText(const std::vector<std::string>& words);
bool contains(const std::vector<std::string>& words, const std::string& word);

/// A finite number in `range`; a string will do when it is wholly numeric, since rosparam takes `1e-3` for a
/// string.
/// @return what is wrong, or nothing
std::string parseNumberIn(const YAML::Node& node, const Range& range, double& number);
}  // namespace detail

/// One word out of several, for an enumeration.
template <typename Value>
Entry choice(const std::string& path, Value& member, Choices<Value> choices) {
  std::vector<std::string> words;
  for (const auto& [word, value] : choices.words) words.push_back(word);
  const auto read = [&member, choices](const YAML::Node& node) -> std::string {
    if (!node.IsScalar()) return "is not a word";
    for (const auto& [word, value] : choices.words) {
      if (node.Scalar() != word) continue;
      member = value;
      return "";
    }
    return "is not known";
  };
  Entry entry{path, detail::wordsText(words), read};
  entry.words = words;
  entry.word = [&member, choices]() -> std::string {
    for (const auto& [word, value] : choices.words)
      if (value == member) return word;
    return "";
  };
  return entry;
}

}  // namespace bs_car_odometry::schema
