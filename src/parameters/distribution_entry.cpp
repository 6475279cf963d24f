#include "entry.hpp"
#include "names.hpp"

#include <algorithm>
#include <set>

namespace bs_car_odometry::schema {
namespace {

using Shape = Distribution::Shape;
using Words = std::vector<std::string>;

const char* const kDistribution = "distribution";
const char* const kDegreesOfFreedom = "degrees_of_freedom";
const char* const kTruncation = "truncation";

/// A word for a shape, and the keys that go with it: first that of its scale.
struct Kind {
  std::string word;
  Shape shape;
  Words keys;
};

const std::vector<Kind> kKinds{
    {"gaussian", Shape::kGaussian, {"std", kTruncation}},
    {"uniform", Shape::kUniform, {"half_width"}},
    {"triangular", Shape::kTriangular, {"half_width"}},
    {"student_t", Shape::kStudentT, {"scale", kDegreesOfFreedom, kTruncation}},
};

Words kindWords() {
  Words words;
  for (const Kind& kind : kKinds) words.push_back(kind.word);
  return words;
}

/// Those that a map of this kind may hold; of any kind when it is not known.
Words keysOf(const Kind* kind) {
  Words keys{kDistribution};
  for (const Kind& candidate : kKinds) {
    if (kind != nullptr && kind != &candidate) continue;
    for (const std::string& key : candidate.keys)
      if (!detail::contains(keys, key)) keys.push_back(key);
  }
  return keys;
}

Fault findKind(const YAML::Node& map, const Kind*& found) {
  const YAML::Node node = map[kDistribution];
  if (!node.IsDefined()) return {};
  const auto kind = std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& candidate) {
    return node.IsScalar() && candidate.word == node.Scalar();
  });
  if (kind == kKinds.end())
    return {kDistribution, valueText(node), "is not known", detail::wordsText(kindWords())};
  found = &*kind;
  return {};
}

Fault checkKeys(const YAML::Node& map, const Words& known) {
  std::set<std::string> seen;
  for (const auto& child : map) {
    const std::string key = child.first.IsScalar() ? child.first.Scalar() : valueText(child.first);
    if (!detail::contains(known, key))
      return {key, "", "is not known",
              detail::wordsText(known) + "; the nearest is " + nearestWord(known, key)};
    if (!seen.insert(key).second) return {key, "", "is given twice", "once"};
  }
  return {};
}

/// The number under `key` of the map, which must be there.
Fault readNumber(const YAML::Node& map, const std::string& key, const Range& range,
                 const std::string& allowed, double& number) {
  const YAML::Node node = map[key];
  if (!node.IsDefined()) return {key, "", "is missing", allowed};
  const std::string wrong = detail::parseNumberIn(node, range, number);
  if (wrong.empty()) return {};
  return {key, valueText(node), wrong, allowed};
}

Fault readDegreesOfFreedom(const YAML::Node& map, bool truncated, double& number) {
  constexpr double kMost = 1e6;  // far beyond what differs from a Gaussian
  const Range range = truncated ? from(1, kMost) : above(2, kMost);
  const std::string allowed = truncated ? range.text() : range.text() + ", or from 1 with a truncation";
  return readNumber(map, kDegreesOfFreedom, range, allowed, number);
}

Fault readTruncation(const YAML::Node& map, double scale, const Range& std_range, double& number) {
  const double low = Distribution::kLeastTruncation * scale;
  const double high = std::min(std_range.high, Distribution::kLargestTruncation * scale);
  const Range range{low, scale > 0.0 ? high : std_range.high, low > 0.0, std_range.unit};
  return readNumber(map, kTruncation, range, range.text(), number);
}

/// The map's numbers, those of its kind.
struct Numbers {
  double scale{0.0};
  double degrees_of_freedom{0.0};
  double truncation{Distribution::kNotTruncated};
};

Fault readNumbers(const YAML::Node& map, const Kind& kind, const Range& range, Numbers& numbers) {
  const bool truncated = map[kTruncation].IsDefined();
  Fault fault = readNumber(map, kind.keys.front(), range, range.text(), numbers.scale);
  if (fault.what.empty() && kind.shape == Shape::kStudentT)
    fault = readDegreesOfFreedom(map, truncated, numbers.degrees_of_freedom);
  if (fault.what.empty() && truncated) fault = readTruncation(map, numbers.scale, range, numbers.truncation);
  return fault;
}

Distribution make(Shape shape, const Numbers& numbers) {
  switch (shape) {
    case Shape::kUniform:
      return Distribution::uniform(numbers.scale);
    case Shape::kTriangular:
      return Distribution::triangular(numbers.scale);
    case Shape::kStudentT:
      return Distribution::studentT(numbers.scale, numbers.degrees_of_freedom, numbers.truncation);
    case Shape::kGaussian:
      break;
  }
  return Distribution::gaussian(numbers.scale, numbers.truncation);
}

Fault readMap(const YAML::Node& map, const Range& range, Distribution& member) {
  const Kind* kind = nullptr;
  Fault fault = findKind(map, kind);
  if (fault.what.empty()) fault = checkKeys(map, keysOf(kind));
  if (!fault.what.empty()) return fault;
  if (kind == nullptr) return {kDistribution, "", "is missing", detail::wordsText(kindWords())};
  Numbers numbers;
  fault = readNumbers(map, *kind, range, numbers);
  if (!fault.what.empty()) return fault;
  const Distribution distribution = make(kind->shape, numbers);
  if (!range.holds(distribution.std()))
    return "has a standard deviation of " + numberText(distribution.std()) + ", which is out of range";
  member = distribution;
  return {};
}

}  // namespace

Entry distribution(const std::string& path, Distribution& member, const Range& range) {
  const auto read = [&member, range](const YAML::Node& node) -> Fault {
    if (node.IsMap()) return readMap(node, range, member);
    double std = 0.0;
    std::string wrong = detail::parseNumberIn(node, range, std);
    if (wrong.empty()) member = std;
    return wrong;
  };
  return {path, range.text() + ", or a map with a distribution (" + detail::wordsText(kindWords()) + ")",
          read};
}

}  // namespace bs_car_odometry::schema
