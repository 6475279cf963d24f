#include "bs_car_odometry/ros/transform_reader.hpp"

namespace bs_car_odometry {

namespace {

constexpr std::size_t kStampBytes = 8;
constexpr std::size_t kTransformBytes = 7 * sizeof(double);
constexpr std::uint32_t kMostNamed = 64;  // characters of a name that may be anything

bool isNamed(const std::string& name, const std::string& frame) {
  return name == frame || (!name.empty() && name.front() == '/' && name.compare(1, name.npos, frame) == 0);
}

geometry_msgs::TransformStamped readTransform(ByteReader& reader) {
  geometry_msgs::TransformStamped stamped;
  stamped.header.seq = reader.value<std::uint32_t>();
  stamped.header.stamp.sec = reader.value<std::uint32_t>();
  stamped.header.stamp.nsec = reader.value<std::uint32_t>();
  stamped.header.frame_id = reader.string();
  stamped.child_frame_id = reader.string();
  auto& translation = stamped.transform.translation;
  auto& rotation = stamped.transform.rotation;
  for (double* number :
       {&translation.x, &translation.y, &translation.z, &rotation.x, &rotation.y, &rotation.z, &rotation.w})
    *number = reader.value<double>();
  return stamped;
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

std::optional<tf2_msgs::TFMessage> readTransforms(const RawMessage<tf2_msgs::TFMessage>& message) {
  constexpr std::size_t kSmallest = 3 * sizeof(std::uint32_t) + kStampBytes + kTransformBytes;
  ByteReader reader(message.bytes);
  tf2_msgs::TFMessage read;
  read.transforms.resize(reader.count(kSmallest));
  for (geometry_msgs::TransformStamped& transform : read.transforms) transform = readTransform(reader);
  if (!reader.sound()) return std::nullopt;
  return read;
}

}  // namespace bs_car_odometry
