#include "entry.hpp"

#include "report.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <locale>
#include <sstream>

namespace bs_car_odometry::schema {

namespace detail {

std::string wordsText(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 == words.size() ? " or " : ", ";
    text += words[i];
  }
  return text;
}

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace detail

using detail::parseNumberIn;

namespace {

/// nan, .inf, -Infinity and the like.
bool namesNonFinite(const std::string& text) {
  std::string word;
  for (const char c : text)
    if (std::isalpha(static_cast<unsigned char>(c)) != 0)
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (c != '+' && c != '-' && c != '.')
      return false;
  return word == "nan" || word == "inf" || word == "infinity";
}

/// A finite number.
/// @return what is wrong, or nothing
std::string parseNumber(const YAML::Node& node, double& number) {
  if (!node.IsScalar()) return "is not a number";
  if (namesNonFinite(node.Scalar())) return "is not finite";
  std::istringstream stream(node.Scalar());
  stream.imbue(std::locale::classic());
  double value = 0.0;
  stream >> std::noskipws >> value;
  if (stream.fail()) return value == 0.0 ? "is not a number" : "is not finite";  // 1e999 fails as the largest
  if (stream.peek() != std::istringstream::traits_type::eof()) return "is not a number";
  number = value;
  return "";
}

std::string parseFlag(const YAML::Node& node, bool& flag) {
  if (!node.IsScalar() || !YAML::convert<bool>::decode(node, flag)) return "is neither true nor false";
  return "";
}

/// Any scalar is a text, a number or a flag too; no value at all is an empty one.
std::string parseText(const YAML::Node& node, std::string& text) {
  if (!node.IsScalar() && !node.IsNull()) return "is not a text";
  text = node.IsNull() ? "" : node.Scalar();
  return "";
}

std::string parseNumbers(const YAML::Node& node, const Range& range, std::vector<double>& numbers) {
  if (!node.IsSequence()) return "is not a list";
  numbers.clear();
  for (const YAML::Node& element : node) {
    double value = 0.0;
    std::string wrong = parseNumberIn(element, range, value);
    if (!wrong.empty()) return "holds " + valueText(element) + ", which " + wrong;
    numbers.push_back(value);
  }
  return "";
}

std::string parseTexts(const YAML::Node& node, std::vector<std::string>& texts) {
  texts.clear();
  std::string single;
  if (parseText(node, single).empty()) {
    if (!single.empty()) texts.push_back(single);
    return "";
  }
  if (!node.IsSequence()) return "is not a list of texts";
  for (const YAML::Node& element : node) {
    if (!element.IsScalar() || element.Scalar().empty())
      return "holds " + valueText(element) + ", which is not a name";
    texts.push_back(element.Scalar());
  }
  return "";
}

/// Tolerances are relative: rounding in a file written with a few digits is no asymmetry.
bool isCovariance(const Eigen::Matrix3d& matrix) {
  constexpr double kTolerance = 1e-9;
  const double scale = matrix.cwiseAbs().maxCoeff();
  if ((matrix - matrix.transpose()).cwiseAbs().maxCoeff() > kTolerance * scale) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() >= -kTolerance * scale;
}

}  // namespace

std::string detail::parseNumberIn(const YAML::Node& node, const Range& range, double& number) {
  double value = 0.0;
  std::string wrong = parseNumber(node, value);
  if (!wrong.empty()) return wrong;
  if (!range.holds(value)) return "is out of range";
  number = value;
  return "";
}

std::string Range::text() const {
  const std::string limits = (low_included ? "a number from " + numberText(low) + " to "
                                           : "a number above " + numberText(low) + ", at most ") +
                             numberText(high);
  return unit.empty() ? limits : limits + " [" + unit + "]";
}

std::string valueText(const YAML::Node& node) {
  if (node.IsNull()) return "(no value)";
  if (node.IsScalar()) return quoted(node.Scalar());
  YAML::Emitter emitter;
  emitter << YAML::Flow << node;
  return quoted(emitter.good() ? emitter.c_str() : "?");
}

Entry number(const std::string& path, double& member, const Range& range) {
  return {path, range.text(),
          [&member, range](const YAML::Node& node) { return parseNumberIn(node, range, member); }};
}

Entry nonZeroNumber(const std::string& path, double& member, const Range& range) {
  const auto read = [&member, range](const YAML::Node& node) -> std::string {
    double value = 0.0;
    std::string wrong = parseNumberIn(node, range, value);
    if (!wrong.empty()) return wrong;
    if (value == 0.0) return "is zero";
    member = value;
    return "";
  };
  return {path, range.text() + ", not 0", read};
}

Entry seconds(const std::string& path, Duration& member, const Range& range) {
  const auto read = [&member, range](const YAML::Node& node) {
    double value = 0.0;
    std::string wrong = parseNumberIn(node, range, value);
    if (wrong.empty()) member = durationFromSeconds(value);
    return wrong;
  };
  return {path, range.text(), read};
}

Entry flag(const std::string& path, bool& member) {
  return {path, "true or false", [&member](const YAML::Node& node) { return parseFlag(node, member); }};
}

Entry text(const std::string& path, std::string& member, const std::string& allowed) {
  return {path, allowed, [&member](const YAML::Node& node) { return parseText(node, member); }};
}

namespace {

std::string readInteger(const YAML::Node& node, int low, int high, bool zero_too, int& member) {
  double value = 0.0;
  std::string wrong = parseNumber(node, value);
  if (!wrong.empty()) return wrong;
  if (value != std::floor(value)) return "is not a whole number";
  if (!(value >= low && value <= high) && !(zero_too && value == 0.0)) return "is out of range";
  member = static_cast<int>(value);
  return "";
}

std::string rangeText(int low, int high) {
  return "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
}

}  // namespace

Entry integer(const std::string& path, int& member, int low, int high) {
  const auto read = [&member, low, high](const YAML::Node& node) {
    return readInteger(node, low, high, false, member);
  };
  return {path, rangeText(low, high), read};
}

Entry zeroOrInteger(const std::string& path, int& member, int low, int high) {
  const auto read = [&member, low, high](const YAML::Node& node) {
    return readInteger(node, low, high, true, member);
  };
  return {path, "0, or " + rangeText(low, high), read};
}

Entry numbers(const std::string& path, std::vector<double>& member, std::size_t fewest, std::size_t most,
              double limit) {
  const Range range = from(-limit, limit);
  const auto read = [&member, fewest, most, range](const YAML::Node& node) -> std::string {
    std::vector<double> values;
    std::string wrong = parseNumbers(node, range, values);
    if (!wrong.empty()) return wrong;
    if (values.size() < fewest || values.size() > most)
      return "has " + std::to_string(values.size()) + " numbers";
    member = values;
    return "";
  };
  return {path,
          "a list of " + std::to_string(fewest) + " to " + std::to_string(most) + " numbers, each from " +
              numberText(-limit) + " to " + numberText(limit),
          read};
}

Entry texts(const std::string& path, std::vector<std::string>& member, std::size_t most,
            const std::string& allowed) {
  const auto read = [&member, most](const YAML::Node& node) -> std::string {
    std::vector<std::string> values;
    std::string wrong = parseTexts(node, values);
    if (!wrong.empty()) return wrong;
    if (values.size() > most) return "has " + std::to_string(values.size()) + " entries";
    member = values;
    return "";
  };
  return {path, allowed, read};
}

Entry subset(const std::string& path, std::vector<std::string>& member,
             const std::vector<std::string>& words) {
  const auto read = [&member, words](const YAML::Node& node) -> std::string {
    std::vector<std::string> values;
    std::string wrong = parseTexts(node, values);
    if (!wrong.empty()) return wrong;
    if (values.empty()) return "is empty";
    for (auto value = values.begin(); value != values.end(); ++value) {
      if (!detail::contains(words, *value)) return "holds " + quoted(*value) + ", which is not known";
      if (std::find(values.begin(), value, *value) != value) return "holds " + quoted(*value) + " twice";
    }
    member = values;
    return "";
  };
  return {path, "a list out of " + detail::wordsText(words), read};
}

Entry covariance(const std::string& path, Eigen::Matrix3d& member) {
  const auto read = [&member](const YAML::Node& node) -> std::string {
    constexpr double kLargest = 1e12;
    std::vector<double> values;
    std::string wrong = parseNumbers(node, from(-kLargest, kLargest), values);
    if (!wrong.empty()) return wrong;
    if (values.size() != 9) return "has " + std::to_string(values.size()) + " numbers";
    const Eigen::Matrix3d matrix = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
    if (!isCovariance(matrix)) return "is no covariance";
    member = matrix;
    return "";
  };
  return {path, "9 numbers, row by row: a symmetric positive semidefinite matrix of x, y [m], yaw [rad]",
          read};
}

Entry required(Entry entry) {
  entry.required = true;
  return entry;
}

Entry oneForBothAxles(Entry entry) {
  entry.one_for_both_axles = true;
  return entry;
}

}  // namespace bs_car_odometry::schema
