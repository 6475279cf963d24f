#include "bs_car_odometry/ros/transform_reader.hpp"

namespace bs_car_odometry {

namespace {

constexpr std::size_t kStampBytes = 8;
constexpr std::size_t kTransformBytes = 7 * sizeof(double);
constexpr std::uint32_t kMostNamed = 64;  // characters of a name that may be anything

bool isNamed(const std::string& name, const std::string& frame) {
  return name == frame || (!name.empty() && name.front() == '/' && name.compare(1, name.npos, frame) == 0);
}

}  // namespace

/// Not ByteReader::count(): what lies beyond the first bytes is not there to be counted.
std::optional<std::string> parentOf(const std::string& child, const RawTransforms& message) {
  ByteReader reader(message.bytes);
  const auto count = reader.value<std::uint32_t>();
  for (std::uint32_t i = 0; i < count && reader.sound(); ++i) {
    reader.value<std::uint32_t>();  // header.seq
    reader.skip(kStampBytes);
    const std::string parent = reader.string();
    const std::string name = reader.string();
    if (reader.skip(kTransformBytes) && isNamed(name, child)) return parent.substr(0, kMostNamed);
  }
  return std::nullopt;
}

}  // namespace bs_car_odometry
