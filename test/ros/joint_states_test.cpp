// input: joint_states drives the car as wheel_ticks do, and lengths that lie do no harm.

#include "any_bytes.hpp"
#include "odometry_client.hpp"

#include <gtest/gtest.h>
#include <sensor_msgs/JointState.h>

#include <cmath>
#include <cstring>

namespace bs_car_odometry::testing {
namespace {

constexpr double kTicksPerRadian = 1.0;  // the joints' metres per radian are the counters' metres per tick

sensor_msgs::JointState jointState(const Ticks& ticks, double angle, const ros::Time& stamp) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  message.name = {"other", "rr", "rl", "fr", "fl", "steering"};
  message.position = {9.0, 0.0, 0.0, 0.0, 0.0, angle};
  for (std::size_t wheel = 0; wheel < kWheels; ++wheel)
    message.position[4 - wheel] = static_cast<double>(ticks[wheel]) / kTicksPerRadian;
  return message;
}

/// An odometry that reads joint states.
class JointClient {
 public:
  JointClient() {
    publisher_ = handle_.advertise<AnyBytes<sensor_msgs::JointState>>("joint_states", kQueueSize);
    subscriber_ = handle_.subscribe<nav_msgs::Odometry>("odom", kQueueSize, [this](const auto& message) {
      EXPECT_EQ(invariants_.violation(*message, ros::Time::now()), "") << *message;
      odometry_.push_back(*message);
    });
  }

  bool connect() {
    return waitFor([this] {
      return publisher_.getNumSubscribers() > 0 && subscriber_.getNumPublishers() > 0 &&
             alive("/joints/odometry") != 0;
    });
  }

  std::optional<nav_msgs::Odometry> step(const Ticks& ticks, double angle) {
    const ros::Time stamp = ros::Time::now();
    send(bytesOf(jointState(ticks, angle, stamp)));
    const auto there = [&] { return !odometry_.empty() && odometry_.back().header.stamp == stamp; };
    if (!waitFor(there)) return std::nullopt;
    return odometry_.back();
  }

  void send(const std::vector<std::uint8_t>& bytes) {
    publisher_.publish(AnyBytes<sensor_msgs::JointState>{bytes});
  }

 private:
  static constexpr std::uint32_t kQueueSize = 5000;
  ros::NodeHandle handle_{"joints"};
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
  Invariants invariants_{InputLimits()};
  std::vector<nav_msgs::Odometry> odometry_;
};

TEST(JointStates, driveAsWheelTicksDo) {
  OdometryClient ticks_car("ticks", "/ticks/odometry");
  JointClient joints_car;
  ASSERT_TRUE(ticks_car.connect() && joints_car.connect());
  const std::size_t transforms = ticks_car.transforms().size();
  for (std::int64_t i = 0; i <= 50; ++i) {
    const Ticks ticks{95 * i, 105 * i, 96 * i, 106 * i};
    const double angle = 0.1 + 1e-3 * static_cast<double>(i);
    const auto a = ticks_car.step(ticks, angle);
    const auto b = joints_car.step(ticks, angle);
    ASSERT_TRUE(a && b);
    // Counters are rounded to ticks, joints are not, which enters the wheels' weights.
    EXPECT_NEAR(a->pose.pose.position.x, b->pose.pose.position.x, 1e-4);
    EXPECT_NEAR(a->pose.pose.position.y, b->pose.pose.position.y, 1e-4);
    EXPECT_NEAR(a->pose.pose.orientation.z, b->pose.pose.orientation.z, 1e-4);
    EXPECT_NEAR(a->pose.covariance[35], b->pose.covariance[35], 1e-3 * a->pose.covariance[35]);
  }
  EXPECT_EQ(ticks_car.transforms().size(), transforms) << "publish_tf: false";
}

TEST(JointStates, publishTfFalseAdvertisesNoTransform) {
  ros::master::V_TopicInfo topics;
  ASSERT_TRUE(ros::master::getTopics(topics));
  for (const ros::master::TopicInfo& topic : topics) EXPECT_NE(topic.name, "/tf");
}

/// Every length field of a message set to lies, and every cut of it.
TEST(JointStates, X1_lying_lengths_do_no_harm) {
  JointClient car;
  ASSERT_TRUE(car.connect());
  const int process = alive("/joints/odometry");
  const auto before = car.step({0, 0, 0, 0}, 0.0);
  ASSERT_TRUE(before);
  const std::vector<std::uint8_t> good = bytesOf(jointState({0, 0, 0, 0}, 0.0, ros::Time::now()));
  for (std::size_t length = 0; length < good.size(); length += 3)
    car.send({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)});
  ASSERT_TRUE(car.step({0, 0, 0, 0}, 0.0));
  for (std::size_t at = 0; at + 4 <= good.size(); at += 2) {
    for (const std::uint32_t lie : {0xffffffffu, 0x7fffffffu, 0x00ffffffu}) {
      std::vector<std::uint8_t> bytes = good;
      std::memcpy(bytes.data() + at, &lie, sizeof(lie));
      // The stamp is no length.
      if (at < 4 || at >= 12) car.send(bytes);
    }
    if (at % 32 == 0) {
      ASSERT_TRUE(car.step({0, 0, 0, 0}, 0.0).has_value());
    }
  }
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(waitFor([&] { return car.step({0, 0, 0, 0}, 0.0).has_value(); }));
  EXPECT_EQ(alive("/joints/odometry"), process) << "invariant 5";
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  return bs_car_odometry::testing::runTests(argc, argv, "joint_states_test");
}
