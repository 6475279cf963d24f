// Any bytes as messages on joint_states and /tf, any numbers as a pose on laser_pose.

#include "bytes.hpp"

#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/laser_input.hpp"
#include "bs_car_odometry/ros/odometry_adapter.hpp"
#include "bs_car_odometry/ros/transform_reader.hpp"

namespace bs_car_odometry::fuzz {
namespace {

Parameters parameters() {
  Parameters parameters;
  parameters.input = InputSource::kJointStates;
  parameters.joints.wheels = {{"fl", "fr", "rl", "rr"}};
  parameters.joints.steering = {{"sl", "sr"}, {"s"}};
  Vehicle& vehicle = parameters.vehicle;
  vehicle.wheelbase = 1.2;
  vehicle.track = {1.2, 1.2};
  vehicle.metres_per_tick.values.fill(0.3);
  vehicle.rear_steering.source = RearSteering::Source::kMeasured;
  parameters.relative_motion.history = Duration::zero();  // reserves memory, which takes most of the time
  return parameters;
}

/// One that has forgotten the last run: to make one takes longer than all that is done with it.
OdometryAdapter& restartedAdapter() {
  static OdometryAdapter adapter(parameters());
  adapter.clockWentBack(true);
  return adapter;
}

ros::Time rawTime(Bytes& bytes) {
  ros::Time time;
  time.sec = bytes.value<std::uint32_t>();
  time.nsec = bytes.value<std::uint32_t>();
  return time;
}

/// Several in turn, each behind its length.
void readJoints(Bytes& bytes) {
  OdometryAdapter& adapter = restartedAdapter();
  for (int i = 0; i < 20 && bytes.sound(); ++i) {
    const std::string text = bytes.string();
    const ros::Time receipt = rawTime(bytes);
    adapter.add(RawJointState{{text.begin(), text.end()}}, receipt);
    while (const auto update = adapter.next(receipt)) require(update->estimate.pose.isFinite(), "finite");
  }
}

void readTransforms(const std::vector<std::uint8_t>& rest) {
  const auto transforms = bs_car_odometry::readTransforms(ByteReader(rest));
  if (!transforms) return;
  parentOf("base_link", *transforms);
  LaserMountFinder finder("base_link", "laser");
  finder.add(*transforms);
  require(!finder.mount() || finder.mount()->isFinite(), "the mount is finite");
}

void readPose(Bytes& bytes) {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.stamp = rawTime(bytes);
  const ros::Time receipt = rawTime(bytes);
  auto& position = message.pose.pose.position;
  auto& orientation = message.pose.pose.orientation;
  for (double* number : {&position.x, &position.y, &position.z, &orientation.x, &orientation.y,
                         &orientation.z, &orientation.w})
    *number = bytes.value<double>();
  for (double& number : message.pose.covariance) number = bytes.value<double>();
  static const Parameters parameters = fuzz::parameters();
  LaserPoseReader reader(parameters);
  const auto read = reader.read(message, receipt);
  const auto* laser = std::get_if<calibration::LaserPose>(&read);
  if (laser != nullptr) require(laser->pose.isFinite() && laser->covariance.allFinite(), "finite");
  restartedAdapter().setPose(message);
}

}  // namespace
}  // namespace bs_car_odometry::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace bs_car_odometry::fuzz;
  if (size == 0) return 0;
  const std::vector<std::uint8_t> rest(data + 1, data + size);
  Bytes bytes(rest);
  switch (data[0] % 3) {
    case 0:
      readJoints(bytes);
      break;
    case 1:
      readTransforms(rest);
      break;
    default:
      readPose(bytes);
  }
  return 0;
}
