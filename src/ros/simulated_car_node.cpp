#include "bs_car_odometry/parameters/load.hpp"
#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/parameter_server.hpp"
#include "bs_car_odometry/ros/simulated_drive.hpp"

#include <ros/ros.h>

#include <limits>
#include <map>
#include <stdexcept>
#include <string>

namespace bs_car_odometry {

namespace {

constexpr double kTimeToConnect = 1.0;  // s, before the drive starts

/// The vehicle's parameters and, beside them, those of the drive.
struct Request {
  Parameters parameters;
  SimulatedDriveSettings drive;
  std::uint32_t subscribers{0};  ///< of the wheels, whom the drive waits for
};

/// Takes `key` out of the tree, so that what remains are parameters of the package.
template <typename T>
void take(YAML::Node& tree, const char* key, T& value) {
  if (!tree[key].IsDefined()) return;
  try {
    value = tree[key].as<T>();
  } catch (const YAML::Exception&) {
    throw std::invalid_argument(std::string("parameter ~") + key + " has the wrong type");
  }
  tree.remove(key);
}

Request readRequest(const ros::NodeHandle& private_node) {
  YAML::Node tree = parameterServerTree(private_node);
  Request request;
  request.drive.scenario = "slalom_eight";
  take(tree, "scenario", request.drive.scenario);
  take(tree, "seed", request.drive.seed);
  take(tree, "rate", request.drive.rate);
  take(tree, "steering_rate", request.drive.steering_rate);
  take(tree, "laser_rate", request.drive.laser_rate);
  take(tree, "duration", request.drive.duration);
  take(tree, "speed_factor", request.drive.speed_factor);
  take(tree, "noise_free", request.drive.noise_free);
  take(tree, "draw_gains", request.drive.draw_gains);
  take(tree, "truth", request.drive.truth);
  take(tree, "subscribers", request.subscribers);
  bool repeat = false;
  take(tree, "repeat", repeat);
  if (repeat) request.drive.duration = std::numeric_limits<double>::infinity();
  const LoadedParameters loaded = loadParameters(tree);
  for (const std::string& warning : loaded.warnings) ROS_WARN_STREAM(warning);
  request.parameters = loaded.parameters;
  return request;
}

/// Publishes each message on its topic, advertised in advance so that subscribers can connect.
class DrivePublishers {
 public:
  DrivePublishers(ros::NodeHandle& node, const Request& request) {
    constexpr std::uint32_t kQueue = 100;
    publishers_["wheel_ticks"] = node.advertise<WheelTicks>("wheel_ticks", kQueue);
    publishers_["front_steering"] = node.advertise<SteeringAngle>("front_steering", kQueue);
    if (request.parameters.vehicle.rear_steering.source == RearSteering::Source::kMeasured)
      publishers_["rear_steering"] = node.advertise<SteeringAngle>("rear_steering", kQueue);
    publishers_["laser_pose"] =
        node.advertise<geometry_msgs::PoseWithCovarianceStamped>("laser_pose", kQueue);
    if (request.drive.truth)
      publishers_["ground_truth"] = node.advertise<nav_msgs::Odometry>("ground_truth", kQueue);
    if (!request.parameters.laser.frame.empty())
      publishers_["tf_static"] = node.advertise<tf2_msgs::TFMessage>("/tf_static", 1, true);
  }

  /// Waits until so many subscribe to the wheels, and a little for their other topics to connect.
  void waitForSubscribers(std::uint32_t count) const {
    const ros::Publisher& wheels = publishers_.at("wheel_ticks");
    while (ros::ok() && wheels.getNumSubscribers() < count) {
      ROS_INFO_STREAM_THROTTLE(5.0, "waiting for " << count << " subscriber(s) of " << wheels.getTopic());
      ros::WallDuration(0.01).sleep();
    }
    ros::WallDuration(kTimeToConnect).sleep();
  }

  void publish(const SimulatedMessage& message) {
    const ros::Publisher& publisher = publishers_.at(message.topic);
    std::visit([&](const auto& content) { publisher.publish(content); }, message.content);
  }

 private:
  std::map<std::string, ros::Publisher> publishers_;
};

void drive(ros::NodeHandle& node, const Request& request) {
  DrivePublishers publishers(node, request);
  ros::Time::waitForValid();
  publishers.waitForSubscribers(request.subscribers);
  SimulatedDrive drive(request.parameters, request.drive, toTime(ros::Time::now()).value());
  ROS_INFO_STREAM("driving " << request.drive.scenario << " with seed " << request.drive.seed
                             << "; the car's true parameters are\n"
                             << describe(drive.truth()));
  while (const std::optional<SimulatedMessage> message = drive.next()) {
    if (!ros::Time::sleepUntil(toRos(message->receipt)) || !ros::ok()) return;
    publishers.publish(*message);
  }
  const simulation::Pose& end = drive.car().truePose();
  ROS_INFO_STREAM("the drive is over after " << drive.duration() << " s, in truth at x " << end.x << " m, y "
                                             << end.y << " m, yaw " << end.yaw << " rad");
}

}  // namespace

}  // namespace bs_car_odometry

int main(int argc, char** argv) {
  ros::init(argc, argv, "simulated_car");
  ros::NodeHandle node;  // outlives the catch: with the last handle the log ends, too
  ros::AsyncSpinner spinner(1);
  spinner.start();
  try {
    bs_car_odometry::drive(node, bs_car_odometry::readRequest(ros::NodeHandle("~")));
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM("the simulated car does not drive. " << error.what());
    return 1;
  }
  return 0;
}
