// A node beside the test, with a name of its own: a rival on the odometry's inputs or on its transform, or
// one that only reads. Which it is, its argument says.

#include "odometry_client.hpp"

#include <string>

namespace bs_car_odometry::testing {
namespace {

constexpr std::uint32_t kQueueSize = 100;
const ros::WallDuration kPeriod(0.01);

/// Counters and angles that no car of the test has.
class RivalDriver {
 public:
  void send() {
    const ros::Time now = ros::Time::now();
    ++count_;
    wheels_.publish(wheelTicks({-count_, 7 * count_, 50 * count_, 0}, now));
    steering_.publish(steeringAngle(0.5, now));
  }

 private:
  ros::NodeHandle node_;
  ros::Publisher wheels_{node_.advertise<WheelTicks>("wheel_ticks", kQueueSize)};
  ros::Publisher steering_{node_.advertise<SteeringAngle>("front_steering", kQueueSize)};
  std::int64_t count_{0};
};

class RivalTransform {
 public:
  void send() {
    tf2_msgs::TFMessage message;
    message.transforms.resize(2);
    message.transforms[0].child_frame_id = "laser";
    message.transforms[1].header.frame_id = "map";
    message.transforms[1].child_frame_id = "base_link";
    for (auto& transform : message.transforms) transform.transform.rotation.w = 1.0;
    publisher_.publish(message);
  }

 private:
  ros::NodeHandle node_;
  ros::Publisher publisher_{node_.advertise<tf2_msgs::TFMessage>("/tf", kQueueSize)};
};

template <typename Rival>
void repeat() {
  Rival rival;
  const ros::WallTimer timer =
      ros::NodeHandle().createWallTimer(kPeriod, [&](const ros::WallTimerEvent&) { rival.send(); });
  ros::spin();
}

template <typename Message>
ros::Subscriber listen(ros::NodeHandle& node, const std::string& topic) {
  const boost::function<void(const boost::shared_ptr<const Message>&)> ignore = [](const auto&) {};
  return node.subscribe<Message>(topic, kQueueSize, ignore);
}

void read() {
  ros::NodeHandle node;
  const ros::Subscriber odom = listen<nav_msgs::Odometry>(node, "odom");
  const ros::Subscriber status = listen<OdometryStatus>(node, "odometry_status");
  const ros::Subscriber transforms = listen<tf2_msgs::TFMessage>(node, "/tf");
  ros::spin();
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  using namespace bs_car_odometry::testing;
  ros::init(argc, argv, "companion");
  const std::string role = argc > 1 ? argv[1] : "";
  if (role == "driver") repeat<RivalDriver>();
  if (role == "transform") repeat<RivalTransform>();
  if (role == "reader") read();
  return 0;
}
