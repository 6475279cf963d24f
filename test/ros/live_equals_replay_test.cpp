// Live equals replay: what the nodelet publishes on a bag that is played is what replay_bag writes of that
// bag, in every byte of every field but header.seq, which counts what a publisher has sent.

#include "any_bytes.hpp"
#include "child_process.hpp"
#include "odometry_client.hpp"
#include "tools/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/JointState.h>
#include <std_srvs/SetBool.h>

#include <map>

namespace bs_car_odometry::testing {
namespace {

using tools::testing::TemporaryFolder;
using Bytes = std::vector<std::uint8_t>;
using Recording = std::map<std::string, std::vector<Bytes>>;  ///< messages of each topic

constexpr const char* kDuration = "16";  // s
constexpr const char* kRate = "20";      // Hz
constexpr const char* kPlayed = "2";     // times as fast
constexpr std::size_t kMessages = 321;
constexpr int kClockMessages = 20;

void clearSequence(tf2_msgs::TFMessage& message) {
  for (auto& transform : message.transforms) transform.header.seq = 0;
}
template <typename Message>
void clearSequence(Message& message) {
  message.header.seq = 0;
}

template <typename Message>
Bytes comparable(Message message) {
  clearSequence(message);
  return bytesOf(message);
}

void run(const std::vector<std::string>& command) {
  ChildProcess program(command);
  ASSERT_EQ(program.waitForExit(), 0) << program.output();
}

/// Adds the counters and angles of a bag to a copy of it as joint states.
void addJoints(const std::string& from, const std::string& to) {
  rosbag::Bag input(from);
  rosbag::Bag output(to, rosbag::bagmode::Write);
  WheelTicks::ConstPtr wheels;
  for (const rosbag::MessageInstance& message : rosbag::View(input)) {
    if (const auto ticks = message.instantiate<WheelTicks>()) {
      wheels = ticks;
      output.write("wheel_ticks", message.getTime(), ticks);
    } else if (const auto angle = message.instantiate<SteeringAngle>()) {
      output.write("front_steering", message.getTime(), angle);
      if (!wheels || wheels->header.stamp != angle->header.stamp) continue;
      sensor_msgs::JointState joints;
      joints.header = angle->header;
      joints.name = {"fl", "fr", "rl", "rr", "steering"};
      joints.position = {static_cast<double>(wheels->front_left), static_cast<double>(wheels->front_right),
                         static_cast<double>(wheels->rear_left), static_cast<double>(wheels->rear_right),
                         angle->angle};
      output.write("joint_states", message.getTime(), joints);
    }
  }
}

/// Messages of a bag that replay_bag wrote, /tf of these frames under its own name.
Recording readBag(const std::string& path) {
  rosbag::Bag bag(path);
  Recording recording;
  for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
    if (const auto odom = message.instantiate<nav_msgs::Odometry>())
      recording["odom"].push_back(comparable(*odom));
    else if (const auto status = message.instantiate<OdometryStatus>())
      recording["odometry_status"].push_back(comparable(*status));
    else if (const auto tf = message.instantiate<tf2_msgs::TFMessage>())
      recording["/tf"].push_back(comparable(*tf));
  }
  return recording;
}

/// What one odometry publishes.
class Recorder {
 public:
  Recorder(const std::string& prefix, const std::string& base_frame) : handle_(prefix) {
    subscribers_.push_back(
        handle_.subscribe<nav_msgs::Odometry>("odom", kQueueSize, [this](const auto& message) {
          EXPECT_EQ(invariants_.violation(*message, ros::Time::now()), "") << *message;
          recording_["odom"].push_back(comparable(*message));
        }));
    subscribers_.push_back(handle_.subscribe<OdometryStatus>(
        "odometry_status", kQueueSize,
        [this](const auto& message) { recording_["odometry_status"].push_back(comparable(*message)); }));
    subscribers_.push_back(
        handle_.subscribe<tf2_msgs::TFMessage>("/tf", kQueueSize, [this, base_frame](const auto& message) {
          if (message->transforms.at(0).child_frame_id == base_frame)
            recording_["/tf"].push_back(comparable(*message));
        }));
  }

  bool connected() const {
    return subscribers_[0].getNumPublishers() > 0 && subscribers_[1].getNumPublishers() > 0 &&
           subscribers_[2].getNumPublishers() > 0;
  }

  bool complete() {
    return recording_["odom"].size() >= kMessages && recording_["odometry_status"].size() >= kMessages &&
           recording_["/tf"].size() >= kMessages;
  }

  void clear() {
    recording_.clear();
    invariants_.announceNewRun();
  }

  Recording& recording() { return recording_; }

 private:
  static constexpr std::uint32_t kQueueSize = 5000;
  ros::NodeHandle handle_;
  Invariants invariants_{InputLimits()};
  Recording recording_;
  std::vector<ros::Subscriber> subscribers_;
};

/// Plays the bag. The player waits until it is heard on every topic and the clock is known, so that nothing
/// is lost.
void play(const std::string& bag, const std::function<bool()>& complete) {
  int clocks = 0;
  const ros::Subscriber clock = ros::NodeHandle().subscribe<rosgraph_msgs::Clock>(
      "/clock", 100, [&](const rosgraph_msgs::Clock::ConstPtr&) { ++clocks; });
  ChildProcess player({"rosbag", "play", "--clock", "--pause", "--wait-for-subscribers", "--rate", kPlayed,
                       bag, "__name:=player", "wheel_ticks:=/ticks/wheel_ticks",
                       "front_steering:=/ticks/front_steering", "joint_states:=/joints/joint_states"});
  ros::ServiceClient pause = ros::NodeHandle().serviceClient<std_srvs::SetBool>("/player/pause_playback");
  ASSERT_TRUE(waitFor([&] { return clocks >= kClockMessages; }, 30.0)) << player.output();
  std_srvs::SetBool resume;
  resume.request.data = false;
  ASSERT_TRUE(pause.call(resume));
  EXPECT_TRUE(waitFor(complete, 40.0)) << player.output();
}

void expectEqual(const Recording& live, const Recording& replayed, const std::string& what) {
  for (const auto& [topic, messages] : replayed) {
    ASSERT_EQ(messages.size(), kMessages) << what << ", replayed " << topic;
    ASSERT_EQ(live.at(topic).size(), kMessages) << what << ", live " << topic;
    for (std::size_t i = 0; i < messages.size(); ++i)
      ASSERT_EQ(live.at(topic)[i], messages[i]) << what << ", " << topic << ", message " << i;
  }
}

class LiveEqualsReplay : public ::testing::Test {
 protected:
  void SetUp() override {
    config_ = ros::param::param<std::string>("~config", "");
    run({BS_CAR_ODOMETRY_SIMULATE, "--scenario", "slalom_eight", "--duration", kDuration, "--rate", kRate,
         "--config", config_, "--output", folder_.file("drive.bag")});
    addJoints(folder_.file("drive.bag"), folder_.file("all.bag"));
  }

  Recording replay(const std::vector<std::string>& settings, const std::string& output = "replayed.bag") {
    std::vector<std::string> command{
        BS_CAR_ODOMETRY_REPLAY, folder_.file("all.bag"), "--config", config_, "--output",
        folder_.file(output)};
    for (const std::string& setting : settings) command.insert(command.end(), {"--set", setting});
    run(command);
    return readBag(folder_.file(output));
  }

  const std::vector<std::string> ticks_settings_{"steering_wait=2.0"};
  const std::vector<std::string> joints_settings_{
      "input=joint_states",          "joints/front_left=fl",  "joints/front_right=fr",
      "joints/rear_left=rl",         "joints/rear_right=rr",  "joints/front_steering=[steering]",
      "base_frame=joints_base_link", "odom_frame=joints_odom"};
  TemporaryFolder folder_;
  std::string config_;
};

TEST_F(LiveEqualsReplay, replayTwiceIsIdentical) {
  const Recording once = replay(ticks_settings_, "once.bag");
  EXPECT_EQ(once.size(), 3u);
  EXPECT_EQ(once.at("odom").size(), kMessages);
  EXPECT_EQ(once, replay(ticks_settings_, "twice.bag"));
}

TEST_F(LiveEqualsReplay, playedBagGivesTheMessagesOfReplayBag) {
  const Recording ticks_replayed = replay(ticks_settings_);
  const Recording joints_replayed = replay(joints_settings_);
  Recorder ticks_live("ticks", "base_link");
  Recorder joints_live("joints", "joints_base_link");
  ASSERT_TRUE(waitFor([&] { return ticks_live.connected() && joints_live.connected(); }));
  const auto complete = [&] { return ticks_live.complete() && joints_live.complete(); };
  play(folder_.file("all.bag"), complete);
  expectEqual(joints_live.recording(), joints_replayed, "joint_states");

  // Topics keep no order among each other: where a machine stalls longer than the time between two messages,
  // an angle may come before the wheels before it, which odometry_status counts. Such a run says nothing; the
  // next one does.
  for (int again = 0; again < 2 && ticks_live.recording() != ticks_replayed; ++again) {
    ticks_live.clear();
    joints_live.clear();
    play(folder_.file("all.bag"), complete);
  }
  expectEqual(ticks_live.recording(), ticks_replayed, "wheel_ticks");
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  return bs_car_odometry::testing::runTests(argc, argv, "live_equals_replay_test");
}
