// CSV recordings to bags: units, counters, times, and the way back out of the bag.

#include "../../src/tools/csv_recording.hpp"
#include "../../src/tools/csv_to_bag_options.hpp"
#include "../../src/tools/recording_bag.hpp"
#include "temporary_folder.hpp"

#include <gmock/gmock.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <cmath>
#include <iterator>
#include <map>
#include <set>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;

constexpr double kPi = 3.14159265358979323846;

class CsvToBag : public ::testing::Test {
 protected:
  /// Messages from a wheel CSV.
  std::vector<WheelTicks> wheels(const std::string& text, const std::string& unit,
                                 CsvSource source = {}) const {
    source.wheels_file = folder_.write("wheels.csv", text);
    source.wheel_unit = wheelUnit(unit);
    return readRecording(source).wheels;
  }

  std::vector<std::int64_t> rearLeft(const std::string& text, const std::string& unit,
                                     const CsvSource& source = {}) const {
    std::vector<std::int64_t> counters;
    for (const WheelTicks& message : wheels(text, unit, source)) counters.push_back(message.rear_left);
    return counters;
  }

  std::string errorIn(const std::string& text, const std::string& unit) const {
    const std::string message = errorOf([&] { wheels(text, unit); });
    return message.substr(std::min(message.find("wheels.csv"), message.size()));
  }

  TemporaryFolder folder_;
};

TEST_F(CsvToBag, ticksAreKeptAsTheyAre) {
  EXPECT_THAT(rearLeft("t,rl\n0,-5\n1,7\n2,4294967296\n", "ticks"), ElementsAre(-5, 7, 4294967296));
}

TEST_F(CsvToBag, incrementsAreSummedFromTheFirstRowOn) {
  EXPECT_THAT(rearLeft("t,rl\n0,9\n1,5\n2,-7\n", "tick_increments"), ElementsAre(0, 5, -2));
}

TEST_F(CsvToBag, metresPerSecondAreIntegratedByTheTrapezoid) {
  // 0 to 2 m/s within 1 s: 1 m; then 2 m/s for 0.5 s: 1 m.
  EXPECT_THAT(rearLeft("t,rl\n0,0\n1,2\n1.5,2\n", "m/s"), ElementsAre(0, 100000, 200000));
}

TEST_F(CsvToBag, turningSpeedsBecomeMetresByTheRadius) {
  CsvSource source;
  source.wheel_radius = 0.3;
  source.metres_per_tick = 1e-3;
  // 60 rpm: one turn a second.
  const auto turn = std::llround(2.0 * kPi * 0.3 / 1e-3);
  EXPECT_THAT(rearLeft("t,rl\n0,60\n1,60\n", "rpm", source), ElementsAre(0, turn));
  EXPECT_THAT(rearLeft("t,rl\n0,-2\n1,-2\n", "rad/s", source), ElementsAre(0, -600));
}

TEST_F(CsvToBag, roundingErrorsDoNotAddUp) {
  // 0.4 ticks a row: rounded one by one they would stay 0 for ever.
  std::string text = "t,rl\n";
  for (int i = 0; i <= 1000; ++i) text += std::to_string(i) + ",4e-6\n";
  EXPECT_EQ(rearLeft(text, "m/s").back(), 400);
}

TEST_F(CsvToBag, countersDoNotWrap) {
  EXPECT_THAT(rearLeft("t,rl\n0,40\n1000,40\n", "m/s"), ElementsAre(0, 4000000000));
}

TEST_F(CsvToBag, aWheelWithoutAColumnStandsStill) {
  const WheelTicks last = wheels("t,rr,fl\n0,1,2\n1,3,4\n", "ticks").back();
  EXPECT_EQ(last.front_left, 4);
  EXPECT_EQ(last.front_right, 0);
  EXPECT_EQ(last.rear_left, 0);
  EXPECT_EQ(last.rear_right, 3);
}

TEST_F(CsvToBag, malformedWheelsAreNamedWithFileAndLine) {
  EXPECT_EQ(errorIn("t,rl\n0,0\n1,1.5\n", "ticks"),
            "wheels.csv:3: 1.500000 in the column 'rl' is not a whole number of ticks");
  EXPECT_EQ(errorIn("t,rl\n0,0\n1,0.5\n", "tick_increments"),
            "wheels.csv:3: 0.500000 in the column 'rl' is not a whole number of ticks");
  EXPECT_EQ(errorIn("t\n0\n", "ticks"), "wheels.csv: no column of a wheel; known: fl, fr, rl, rr");
  EXPECT_EQ(errorIn("t,f\n0,1\n", "ticks"),
            "wheels.csv:1: unknown column 'f'; known, separated by commas: t, fl, fr, rl, rr");
  EXPECT_THAT(errorIn("t,rl\n0,1e30\n1,1e30\n", "m/s"),
              HasSubstr("wheels.csv:3: the counter leaves its range"));
  EXPECT_THAT(errorIn("t,rl\n1e300,0\n", "ticks"), HasSubstr("is no time that ROS knows"));
  EXPECT_THAT(errorIn("t,rl\n3,0\n2,0\n", "ticks"), HasSubstr("wheels.csv:3: the time goes back"));
  EXPECT_THAT(errorOf([] { wheelUnit("km/h"); }),
              HasSubstr("known: ticks, tick_increments, m/s, rpm, rad/s"));
}

TEST_F(CsvToBag, shortTimesAreMovedAndLongOnesKept) {
  EXPECT_EQ(wheels("t,rl\n0.000001,0\n", "ticks")[0].header.stamp, ros::Time(1600000000, 1000));
  EXPECT_EQ(wheels("t,rl\n-0.25,0\n", "ticks")[0].header.stamp, ros::Time(1599999999, 750000000));
  EXPECT_EQ(wheels("t,rl\n1000000,0\n", "ticks")[0].header.stamp, ros::Time(1000000, 0));
  EXPECT_EQ(wheels("t,rl\n1500000000.5,0\n", "ticks")[0].header.stamp, ros::Time(1500000000, 500000000));
}

TEST_F(CsvToBag, allFilesAreMovedByTheSameAmount) {
  CsvSource source;
  source.wheels_file = folder_.write("wheels.csv", "t,rl\n1000000.5,0\n");
  source.steering_file = folder_.write("steering.csv", "t,angle\n999999.5,0.1\n");
  const Recording recording = readRecording(source);
  EXPECT_EQ(recording.wheels[0].header.stamp, ros::Time(1601000000, 500000000));
  EXPECT_EQ(recording.front_steering[0].header.stamp, ros::Time(1600999999, 500000000));
  folder_.write("wheels.csv", "t,rl\n999999.5,0\n");
  folder_.write("steering.csv", "t,angle\n1000000.5,0.1\n");
  EXPECT_EQ(readRecording(source).front_steering[0].header.stamp, ros::Time(1601000000, 500000000));
  folder_.write("steering.csv", "t,angle\n1500000000,0.1\n");
  EXPECT_THAT(errorOf([&] { readRecording(source); }), EndsWith("do not begin on the same clock"));
}

TEST_F(CsvToBag, steeringIsDividedByTheRatio) {
  CsvSource source;
  source.wheels_file = folder_.write("wheels.csv", "t,rl\n0,0\n");
  source.steering_file = folder_.write("steering.csv", "t,angle\n0,90\n");
  source.radians_per_unit = kPi / 180.0;
  source.steering_ratio = 15.0;
  const Recording recording = readRecording(source);
  EXPECT_NEAR(recording.front_steering[0].angle, kPi / 30.0, 1e-15);
  EXPECT_TRUE(recording.rear_steering.empty());
}

TEST_F(CsvToBag, steeringColumnsAreOneAngleOrBothAxles) {
  CsvSource source;
  source.wheels_file = folder_.write("wheels.csv", "t,rl\n0,0\n");
  source.steering_file = folder_.write("steering.csv", "rear,t,front\n-0.1,0,0.2\n");
  const Recording recording = readRecording(source);
  EXPECT_EQ(recording.front_steering[0].angle, 0.2);
  EXPECT_EQ(recording.rear_steering[0].angle, -0.1);
  for (const char* text : {"t,front\n0,0\n", "t,angle,rear\n0,0,0\n", "t\n0\n"}) {
    folder_.write("steering.csv", text);
    EXPECT_THAT(errorOf([&] { readRecording(source); }), EndsWith("expected: t, angle or t, front, rear"))
        << text;
  }
}

TEST_F(CsvToBag, posesNeedAllTheirColumns) {
  CsvSource source;
  source.wheels_file = folder_.write("wheels.csv", "t,rl\n0,0\n");
  source.pose_file = folder_.write("pose.csv", "t,x,y\n0,0,0\n");
  EXPECT_THAT(errorOf([&] { readRecording(source); }), EndsWith("'yaw' is missing; expected: t, x, y, yaw"));
}

/// The messages of one type and topic, with their record times equal to their stamps.
template <typename Message>
std::vector<Message> messagesOf(const std::string& bag_file, const std::string& topic) {
  rosbag::Bag bag(bag_file);
  std::vector<Message> messages;
  for (const rosbag::MessageInstance& instance : rosbag::View(bag, rosbag::TopicQuery(topic))) {
    const auto message = instance.instantiate<Message>();
    if (message == nullptr) continue;
    EXPECT_EQ(message->header.stamp, instance.getTime());
    messages.push_back(*message);
  }
  return messages;
}

class WrittenBag : public CsvToBag {
 protected:
  void SetUp() override {
    const std::string wheels = folder_.write("wheels.csv", "t,fl,fr,rl,rr\n0,0,0,0,0\n0.1,1,2,3,4\n");
    const std::string steering = folder_.write("steering.csv", "t,front,rear\n0.1,-90,45\n");
    const std::string poses = folder_.write("pose.csv", "t,x,y,yaw\n0.05,1,2,7\n");
    const char* arguments[] = {"csv_to_bag",     "--wheels",        wheels.c_str(), "--steering",
                               steering.c_str(), "--pose",          poses.c_str(),  "--output",
                               bag_.c_str(),     "--steering-unit", "deg",          "ground_truth:=gt"};
    const CsvToBagOptions options = csvToBagOptions(static_cast<int>(std::size(arguments)), arguments);
    writeBag(options.output, readRecording(options.source), options.topics);
  }

  const std::string bag_{folder_.file("out.bag")};
  const ros::Time begin_{1600000000, 0};
};

TEST_F(WrittenBag, holdsItsTopicsAndNothingElse) {
  EXPECT_EQ(folder_.files(), 4u);
  rosbag::Bag bag(bag_);
  std::set<std::string> topics;
  for (const rosbag::ConnectionInfo* connection : rosbag::View(bag).getConnections())
    topics.insert(connection->topic);
  EXPECT_THAT(topics, ElementsAre("/front_steering", "/gt", "/laser_pose", "/rear_steering", "/wheel_ticks"));
}

TEST_F(WrittenBag, wheelsAreReadBack) {
  const std::vector<WheelTicks> wheels = messagesOf<WheelTicks>(bag_, "/wheel_ticks");
  ASSERT_EQ(wheels.size(), 2u);
  EXPECT_EQ(wheels[0].header.stamp, begin_);
  EXPECT_EQ(wheels[1].header.stamp, begin_ + ros::Duration(0.1));
  EXPECT_EQ(wheels[1].front_left, 1);
  EXPECT_EQ(wheels[1].front_right, 2);
  EXPECT_EQ(wheels[1].rear_left, 3);
  EXPECT_EQ(wheels[1].rear_right, 4);
}

TEST_F(WrittenBag, steeringIsReadBack) {
  const std::vector<SteeringAngle> front = messagesOf<SteeringAngle>(bag_, "/front_steering");
  const std::vector<SteeringAngle> rear = messagesOf<SteeringAngle>(bag_, "/rear_steering");
  ASSERT_EQ(front.size(), 1u);
  ASSERT_EQ(rear.size(), 1u);
  EXPECT_EQ(front[0].header.stamp, begin_ + ros::Duration(0.1));
  EXPECT_NEAR(front[0].angle, -kPi / 2, 1e-15);
  EXPECT_NEAR(rear[0].angle, kPi / 4, 1e-15);
}

TEST_F(WrittenBag, posesAreReadBackAsLaserPoseAndTruth) {
  const auto poses = messagesOf<geometry_msgs::PoseWithCovarianceStamped>(bag_, "/laser_pose");
  const auto truths = messagesOf<nav_msgs::Odometry>(bag_, "/gt");
  ASSERT_EQ(poses.size(), 1u);
  ASSERT_EQ(truths.size(), 1u);
  const geometry_msgs::Pose& pose = poses[0].pose.pose;
  EXPECT_EQ(poses[0].header.frame_id, "map");
  EXPECT_EQ(poses[0].header.stamp, begin_ + ros::Duration(0.05));
  EXPECT_EQ(pose.position.x, 1.0);
  EXPECT_EQ(pose.position.y, 2.0);
  EXPECT_NEAR(2.0 * std::atan2(pose.orientation.z, pose.orientation.w), 7.0 - 4.0 * kPi, 1e-12);
  EXPECT_THAT(poses[0].pose.covariance, ::testing::Each(0.0));
  EXPECT_EQ(truths[0].header.stamp, poses[0].header.stamp);
  EXPECT_EQ(truths[0].header.frame_id, "odom");
  EXPECT_EQ(truths[0].child_frame_id, "base_link");
  EXPECT_EQ(truths[0].pose.pose, pose);
}

TEST_F(CsvToBag, atTheSameTimeSteeringIsWrittenBeforeWheels) {
  CsvSource source;
  source.wheels_file = folder_.write("wheels.csv", "t,rl\n0,0\n");
  source.steering_file = folder_.write("steering.csv", "t,angle\n0,0\n");
  writeBag(folder_.file("out.bag"), readRecording(source), {});
  // The order of writing is that of the file's connections.
  rosbag::Bag bag(folder_.file("out.bag"));
  std::map<std::uint32_t, std::string> topics;
  for (const rosbag::ConnectionInfo* connection : rosbag::View(bag).getConnections())
    topics[connection->id] = connection->topic;
  EXPECT_THAT(topics, ElementsAre(std::make_pair(0u, "/front_steering"), std::make_pair(1u, "/wheel_ticks")));
}

std::string optionError(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), {"csv_to_bag", "--wheels", "w.csv", "--output", "o.bag"});
  return errorOf([&] { csvToBagOptions(static_cast<int>(arguments.size()), arguments.data()); });
}

TEST(CsvToBagOptionsTest, mistakesAreNamed) {
  EXPECT_EQ(optionError({}), "");
  EXPECT_THAT(optionError({"--wheel-unit", "km/h"}), HasSubstr("'km/h'"));
  EXPECT_THAT(optionError({"--wheel-unit", "rpm"}), HasSubstr("needs --wheel-radius"));
  EXPECT_THAT(optionError({"--wheel-unit", "rad/s", "--wheel-radius", "0"}),
              HasSubstr("--wheel-radius must be"));
  EXPECT_THAT(optionError({"--metres-per-tick", "nan"}), HasSubstr("--metres-per-tick must be"));
  EXPECT_THAT(optionError({"--steering-unit", "grad"}), HasSubstr("'grad'"));
  EXPECT_THAT(optionError({"--steering-ratio", "0"}), HasSubstr("--steering-ratio must be"));
  EXPECT_THAT(optionError({"wheel_tick:=a"}), HasSubstr("known: wheel_ticks"));
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
