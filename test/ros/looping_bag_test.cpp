// T5: a bag that is played over and over. Each run begins anew and publishes in every bit what the first did.

#include "any_bytes.hpp"
#include "child_process.hpp"
#include "odometry_client.hpp"
#include "support/figure.hpp"
#include "tools/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosgraph_msgs/Clock.h>
#include <std_srvs/SetBool.h>

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::testing {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr int kLoops = 20;
constexpr std::size_t kMessages = 60;
constexpr double kBegin = 1.6e9;  // s
constexpr double kPeriod = 0.02;  // s
constexpr double kPause = 0.3;  // s after the last one, so that it does not come together with the next clock

/// A slalom of 1.2 s, with a message on a topic of nobody's as its end.
void writeBag(const std::string& path) {
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  for (std::size_t i = 0; i < kMessages; ++i) {
    const ros::Time stamp(kBegin + kPeriod * static_cast<double>(i));
    const auto ticks = static_cast<std::int64_t>(200 * i);
    bag.write("front_steering", stamp, steeringAngle(0.2 * std::sin(0.1 * static_cast<double>(i)), stamp));
    bag.write("wheel_ticks", stamp, wheelTicks({ticks, ticks + 5, ticks - 3, ticks}, stamp));
  }
  const ros::Time end(kBegin + kPeriod * static_cast<double>(kMessages) + kPause);
  bag.write("end", end, steeringAngle(0.0, end));
}

template <typename Message>
Bytes bytesWithoutSequence(Message message) {
  message.header.seq = 0;
  return bytesOf(message);
}

/// What one topic brought, run by run: a stamp that is not after the one before begins another one.
class Runs {
 public:
  template <typename Message>
  void add(const Message& message) {
    if (runs_.empty() || message.header.stamp <= newest_) {
      runs_.emplace_back();
      begins_.push_back(ros::SteadyTime::now());
    }
    newest_ = message.header.stamp;
    runs_.back().push_back(bytesWithoutSequence(message));
  }

  /// The last one may still go on.
  std::size_t finished() const { return runs_.empty() ? 0 : runs_.size() - 1; }
  const std::vector<Bytes>& operator[](std::size_t run) const { return runs_[run]; }
  const ros::SteadyTime& begin(std::size_t run) const { return begins_[run]; }

 private:
  ros::Time newest_;
  std::vector<std::vector<Bytes>> runs_;
  std::vector<ros::SteadyTime> begins_;
};

class LoopingBag : public ::testing::Test {
 protected:
  void SetUp() override {
    subscribers_.push_back(node_.subscribe<nav_msgs::Odometry>("odom", 1000, [this](const auto& message) {
      const ros::Time stamp = message->header.stamp;
      if (stamp <= newest_) invariants_.announceNewRun();
      newest_ = stamp;
      EXPECT_EQ(invariants_.violation(*message, stamp), "");
      odom_.add(*message);
    }));
    subscribers_.push_back(
        node_.subscribe<OdometryStatus>("odometry_status", 1000, [this](const auto& message) {
          // Topics keep no order among each other: the next angle may be counted before the wheels before it.
          OdometryStatus status = *message;
          status.steering_messages = 0;
          status_.add(status);
        }));
    subscribers_.push_back(node_.subscribe<tf2_msgs::TFMessage>(
        "/tf", 1000, [this](const auto& message) { transforms_.add(message->transforms.at(0)); }));
    subscribers_.push_back(node_.subscribe<rosgraph_msgs::Clock>("/clock", 1000, [this](const auto& message) {
      if (clocks_ == 0 || message->clock < clock_) steps_.push_back(ros::SteadyTime::now());
      ++clocks_;
      clock_ = message->clock;
    }));
    ASSERT_TRUE(waitFor([this] {
      return std::all_of(subscribers_.begin(), subscribers_.begin() + 3,
                         [](const ros::Subscriber& one) { return one.getNumPublishers() > 0; });
    }));
  }

  /// Plays the bag again and again, once it is heard and everybody knows the clock.
  void play(const std::function<bool()>& enough) {
    const tools::testing::TemporaryFolder folder;
    writeBag(folder.file("loop.bag"));
    ChildProcess player({"rosbag", "play", "--clock", "--hz", "500", "--loop", "--pause", "--quiet", "--rate",
                         "2", "--wait-for-subscribers", "--topics", "wheel_ticks", "front_steering", "end",
                         "--bags", folder.file("loop.bag"), "__name:=player"});
    const boost::function<void(const SteeringAngle::ConstPtr&)> ignore = [](const auto&) {};
    const ros::Subscriber end = node_.subscribe<SteeringAngle>("end", 1, ignore);
    ASSERT_TRUE(waitFor([&] { return clocks_ > 20; }, 30.0)) << player.output();
    std_srvs::SetBool resume;
    resume.request.data = false;
    ASSERT_TRUE(ros::service::call("/player/pause_playback", resume));
    ASSERT_TRUE(waitFor(enough, 60.0)) << player.output();
  }

  ros::NodeHandle node_;
  Invariants invariants_{InputLimits()};
  Runs odom_;
  Runs status_;
  Runs transforms_;
  ros::Time newest_;
  ros::Time clock_;
  int clocks_{0};
  std::vector<ros::SteadyTime> steps_;  ///< when the clock began, and went back
  std::vector<ros::Subscriber> subscribers_;
};

TEST_F(LoopingBag, T5_twenty_loops_are_identical_in_every_bit) {
  ASSERT_NO_FATAL_FAILURE(play([&] {
    return odom_.finished() > kLoops && status_.finished() > kLoops && transforms_.finished() > kLoops;
  }));
  for (const Runs* runs : {&odom_, &status_, &transforms_}) {
    ASSERT_EQ((*runs)[0].size(), kMessages);
    for (std::size_t run = 1; run <= kLoops; ++run)
      ASSERT_EQ((*runs)[run], (*runs)[0]) << "run " << run << ", " << (*runs)[run].size() << " messages";
  }
  ASSERT_GT(steps_.size(), static_cast<std::size_t>(kLoops));
  double latest = 0.0;
  for (std::size_t run = 1; run <= kLoops; ++run)
    latest = std::max(latest, (odom_.begin(run) - steps_[run]).toSec());
  recordFigure(
      "%d loops of a bag, identical in every bit; the first message within %g s of the step of the clock",
      static_cast<int>(kLoops), roundedUp(latest));
  EXPECT_LT(latest, 0.1);
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) { return bs_car_odometry::testing::runTests(argc, argv, "looping_bag_test"); }
