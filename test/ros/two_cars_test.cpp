// N6: two cars in one manager, each of which publishes in every bit what it publishes alone.

#include "any_bytes.hpp"
#include "odometry_client.hpp"
#include "support/figure.hpp"

#include <gtest/gtest.h>
#include <rosgraph_msgs/Clock.h>
#include <std_srvs/Trigger.h>

#include <cmath>

namespace bs_car_odometry::testing {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr int kSteps = 200;
constexpr double kPeriod = 0.05;  // s

/// One odometry: its driver, and every byte that it publishes but for header.seq.
class Car {
 public:
  Car(const std::string& prefix, const std::string& base_frame, bool transforms)
      : node_(prefix), expects_transforms_(transforms) {
    wheels_ = node_.advertise<WheelTicks>("wheel_ticks", 10);
    steering_ = node_.advertise<SteeringAngle>("front_steering", 10);
    subscribers_.push_back(node_.subscribe<nav_msgs::Odometry>("odom", 10, [this](const auto& message) {
      // The test's own clock may come after that of the cars.
      EXPECT_EQ(invariants_.violation(*message, message->header.stamp), "");
      add(*message, odom_);
    }));
    subscribers_.push_back(node_.subscribe<OdometryStatus>(
        "odometry_status", 10, [this](const auto& message) { add(*message, status_); }));
    // Both cars of one manager publish on /tf, each its own frame.
    subscribers_.push_back(
        node_.subscribe<tf2_msgs::TFMessage>("/tf", 100, [this, base_frame](const auto& message) {
          const geometry_msgs::TransformStamped& transform = message->transforms.at(0);
          if (transform.child_frame_id == base_frame) add(transform, transforms_);
        }));
  }

  bool connected() const {
    return wheels_.getNumSubscribers() > 0 && steering_.getNumSubscribers() > 0 &&
           subscribers_[0].getNumPublishers() > 0 && subscribers_[1].getNumPublishers() > 0;
  }

  void send(const Ticks& ticks, double angle, const ros::Time& stamp) {
    steering_.publish(steeringAngle(angle, stamp));
    wheels_.publish(wheelTicks(ticks, stamp));
  }

  bool hasHeard(std::size_t messages) const {
    return odom_.size() >= messages && status_.size() >= messages &&
           (!expects_transforms_ || transforms_.size() >= messages);
  }

  /// Forgets what was heard, and what is older than a stamp from now on.
  void clear(const ros::Time& from) {
    odom_.clear();
    status_.clear();
    transforms_.clear();
    from_ = from;
    invariants_.announceJump();
  }

  const std::vector<Bytes>& odom() const { return odom_; }
  const std::vector<Bytes>& status() const { return status_; }

 private:
  template <typename Message>
  void add(Message message, std::vector<Bytes>& to) const {
    if (message.header.stamp < from_) return;
    message.header.seq = 0;
    to.push_back(bytesOf(message));
  }

  ros::NodeHandle node_;
  bool expects_transforms_;
  ros::Time from_;
  std::vector<Bytes> odom_;
  std::vector<Bytes> status_;
  std::vector<Bytes> transforms_;
  Invariants invariants_{InputLimits()};
  ros::Publisher wheels_;
  ros::Publisher steering_;
  std::vector<ros::Subscriber> subscribers_;
};

/// Four cars by simulated time: two in one manager, and the same two each in a process of its own. Those have
/// the frames of the first two, and therefore do not publish on /tf.
class TwoCars : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(waitFor(
        [&] { return a_.connected() && b_.connected() && a_alone_.connected() && b_alone_.connected(); }));
    // Everybody must have heard the clock before what is compared begins. From one step to the next it may
    // come after the messages, which are then ahead of it by less than max_future.
    const auto all = [&] { return heard(1); };
    ASSERT_TRUE(waitFor([&] {
      setClock(ros::Time(100.0 - kPeriod));
      drive(0, ros::Time(100.0 - kPeriod));
      return all();
    }));
    for (const char* name : {"/a", "/b", "/a_alone", "/b_alone"}) {
      std_srvs::Trigger reset;
      ASSERT_TRUE(ros::service::call(std::string(name) + "/odometry/reset", reset) && reset.response.success);
    }
    // What was sent while they listened already is still on its way, but older than what comes.
    for (Car* car : {&a_, &b_, &a_alone_, &b_alone_}) car->clear(ros::Time(100.0));
  }

  void setClock(const ros::Time& now) {
    rosgraph_msgs::Clock message;
    message.clock = now;
    clock_.publish(message);
  }

  /// One car turns to the left, the other one reverses to the right.
  void drive(int step, const ros::Time& stamp) {
    const std::int64_t i = step;
    for (Car* car : {&a_, &a_alone_})
      car->send({90 * i, 110 * i, 91 * i, 109 * i}, 0.1 * std::sin(0.1 * step), stamp);
    for (Car* car : {&b_, &b_alone_})
      car->send({-50 * i, -40 * i, -51 * i, -39 * i}, -0.2 * std::cos(0.07 * step), stamp);
  }

  bool heard(std::size_t messages) const {
    return a_.hasHeard(messages) && b_.hasHeard(messages) && a_alone_.hasHeard(messages) &&
           b_alone_.hasHeard(messages);
  }

  ros::Publisher clock_{ros::NodeHandle().advertise<rosgraph_msgs::Clock>("/clock", 10)};
  Car a_{"a", "a_base_link", true};
  Car b_{"b", "b_base_link", true};
  Car a_alone_{"a_alone", "a_base_link", false};
  Car b_alone_{"b_alone", "b_base_link", false};
};

TEST_F(TwoCars, N6_in_one_manager_publish_what_each_publishes_alone) {
  for (int step = 0; step <= kSteps; ++step) {
    const ros::Time now(100.0 + kPeriod * step);
    setClock(now);
    drive(step, now);
    ASSERT_TRUE(waitFor([&] { return heard(static_cast<std::size_t>(step) + 1); })) << "step " << step;
  }
  EXPECT_EQ(a_.odom(), a_alone_.odom());
  EXPECT_EQ(a_.status(), a_alone_.status());
  EXPECT_EQ(b_.odom(), b_alone_.odom());
  EXPECT_EQ(b_.status(), b_alone_.status());
  EXPECT_NE(a_.odom(), b_.odom());
  recordFigure("identical in every bit");
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) { return bs_car_odometry::testing::runTests(argc, argv, "two_cars_test"); }
