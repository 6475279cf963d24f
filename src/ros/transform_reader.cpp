#include "bs_car_odometry/ros/transform_reader.hpp"

#include <boost/make_shared.hpp>

#include <utility>

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

std::optional<std::string> parentOf(const std::string& child, const tf2_msgs::TFMessage& message) {
  for (const geometry_msgs::TransformStamped& transform : message.transforms)
    if (isNamed(transform.child_frame_id, child)) return transform.header.frame_id.substr(0, kMostNamed);
  return std::nullopt;
}

std::optional<tf2_msgs::TFMessage> readTransforms(ByteReader reader) {
  constexpr std::size_t kSmallest = 3 * sizeof(std::uint32_t) + kStampBytes + kTransformBytes;
  tf2_msgs::TFMessage read;
  read.transforms.resize(reader.count(kSmallest));
  for (geometry_msgs::TransformStamped& transform : read.transforms) transform = readTransform(reader);
  if (!reader.sound()) return std::nullopt;
  return read;
}

TransformsCallback::TransformsCallback(const Callback& callback) : SubscriptionCallbackHelperT(callback) {}

ros::VoidConstPtr TransformsCallback::deserialize(
    const ros::SubscriptionCallbackHelperDeserializeParams& received) {
  std::optional<tf2_msgs::TFMessage> read =
      readTransforms(ByteReader({reinterpret_cast<const char*>(received.buffer), received.length}));
  if (!read) return {};
  return boost::make_shared<tf2_msgs::TFMessage>(std::move(*read));
}

}  // namespace bs_car_odometry
