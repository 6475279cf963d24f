// X1: every field of every input message spoiled, over a real master, between the messages of good drives.
// $BS_CAR_ODOMETRY_FUZZED_MESSAGES says how many there are in all.

#include "any_bytes.hpp"
#include "calibration_client.hpp"
#include "hostile_bytes.hpp"
#include "odometry_client.hpp"

#include "bs_car_odometry/CalibrationState.h"
#include "bs_car_odometry/calibration/result_file.hpp"
#include "bs_car_odometry/parameters/load.hpp"
#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/parameter_server.hpp"

#include <gtest/gtest.h>
#include <sensor_msgs/JointState.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <iostream>

namespace bs_car_odometry::testing {
namespace {

using Pose = geometry_msgs::PoseWithCovarianceStamped;

constexpr std::uint64_t kSeed = 20;
constexpr int kBatch = 40;  // messages of each topic between two good ones, fewer than the queues hold

int partOfAll(double share) {
  const char* all = std::getenv("BS_CAR_ODOMETRY_FUZZED_MESSAGES");
  return static_cast<int>(share * (all == nullptr ? 100000.0 : std::stod(all)));
}

/// A topic on which good messages are sent, and spoiled ones.
template <typename Message>
class Topic {
 public:
  Topic(const std::string& name, std::uint64_t stream) : hostile_(kSeed + stream) {
    publisher_ = ros::NodeHandle().advertise<AnyBytes<Message>>(name, 5000);
  }
  void send(const Message& message) { publisher_.publish(AnyBytes<Message>{bytesOf(message)}); }
  void sendSpoiled(const Message& good) {
    publisher_.publish(AnyBytes<Message>{hostile_.spoil(bytesOf(good))});
    ++spoiled_;
  }
  /// Of a drive in the past: a stamp between it and the clock would be believed, and the drive be over.
  void sendSpoiledOfThePast(const Message& good) {
    const std::vector<std::uint8_t> good_bytes = bytesOf(good);
    std::vector<std::uint8_t> bytes = hostile_.spoil(good_bytes);
    constexpr std::size_t kStamp = 4;  // behind header.seq
    std::uint32_t sec = 0;
    if (bytes.size() >= kStamp + 8) std::memcpy(&sec, bytes.data() + kStamp, sizeof sec);
    if (sec > good.header.stamp.sec && sec <= ros::Time::now().sec)
      std::memcpy(bytes.data() + kStamp, good_bytes.data() + kStamp, 8);
    publisher_.publish(AnyBytes<Message>{bytes});
    ++spoiled_;
  }
  bool connected(std::uint32_t listeners = 1) const { return publisher_.getNumSubscribers() >= listeners; }
  int spoiled() const { return spoiled_; }

 private:
  HostileBytes hostile_;
  ros::Publisher publisher_;
  int spoiled_{0};
};

Parameters parametersOf(const std::string& node) {
  return loadParameters(parameterServerTree(ros::NodeHandle(node))).parameters;
}

/// Names of four characters, so that the fields after them lie at multiples of four bytes.
Pose poseIn(const std::string& frame, const ros::Time& stamp) {
  Pose pose;
  pose.header.frame_id = frame;
  pose.header.stamp = stamp;
  pose.pose.pose.orientation.w = 1.0;
  for (const std::size_t i : {0, 7, 35}) pose.pose.covariance[i] = 1e-4;
  return pose;
}

CalibrationState perfectCar(const Parameters& parameters) {
  CalibrationState state;
  state.header.stamp = ros::Time::now();
  state.vehicle = parameters.vehicle.name;
  state.vehicle_checksum = calibration::vehicleChecksum(parameters);
  const calibration::ParameterVector values = calibration::valuesOf(parameters);
  for (std::size_t i = 0; i < calibration::kCount; ++i) {
    state.value[i] = values[static_cast<Eigen::Index>(i)];
    state.observed[i] = true;
    state.covariance[i * (calibration::kCount + 1)] = 1e-8;
  }
  return state;
}

tf2_msgs::TFMessage link(const std::string& parent, const std::string& child) {
  tf2_msgs::TFMessage message;
  message.transforms.resize(2);
  for (geometry_msgs::TransformStamped& transform : message.transforms) {
    transform.header.stamp = ros::Time::now();
    transform.header.frame_id = parent;
    transform.child_frame_id = child;
    transform.transform.rotation.w = 1.0;
  }
  return message;
}

sensor_msgs::JointState jointState(double wheels, const ros::Time& stamp) {
  sensor_msgs::JointState message;
  message.header.stamp = stamp;
  message.name = {"fl", "fr", "rl", "rr", "steering"};
  message.position = {wheels, wheels, wheels, wheels, 0.0};
  return message;
}

/// Sends a good message again until the odometry of its stamp is there: a spoiled one may have been believed
/// that is ahead of the clock, by at most max_future.
template <typename Send>
bool goesOn(const OdometryClient& client, const Send& send) {
  for (int i = 0; i < 100; ++i) {
    const ros::Time stamp = ros::Time::now();
    send(stamp);
    if (waitFor([&] { return !client.odometry().empty() && client.odometry().back().header.stamp == stamp; },
                0.15))
      return true;
  }
  return false;
}

/// A car with two steering sensors in the nodelet, which also takes poses and calibrations.
class OdometryUnderFire {
 public:
  bool connect() {
    client_.ignoreTransforms();  // spoiled ones are none
    return client_.connect() && waitFor([this] {
             return wheels_.connected() && front_.connected() && rear_.connected() && set_pose_.connected() &&
                    calibration_.connected() && tf_.connected();
           });
  }

  void sendSpoiled() {
    const ros::Time now = ros::Time::now();
    wheels_.sendSpoiled(wheelTicks({ticks_, ticks_, ticks_, ticks_}, now));
    front_.sendSpoiled(steeringAngle(0.0, now));
    rear_.sendSpoiled(steeringAngle(0.0, now));
    calibration_.sendSpoiled(good_calibration_);
    tf_.sendSpoiled(link("some", "base_link"));
  }
  void sendSpoiledPose() { set_pose_.sendSpoiled(poseIn("odom", ros::Time::now())); }

  /// 10 mm straight ahead.
  bool step() {
    ticks_ += 100;
    return goesOn(client_, [this](const ros::Time& stamp) {
      for (Topic<SteeringAngle>* steering : {&front_, &rear_}) steering->send(steeringAngle(0.0, stamp));
      wheels_.send(wheelTicks({ticks_, ticks_, ticks_, ticks_}, stamp));
    });
  }

  /// With the gains that it had, which spoiled messages may have changed.
  void calibrate() { calibration_.send(good_calibration_); }

  OdometryClient& client() { return client_; }
  /// Messages of wheels and steering that were sent spoiled, and those that the odometry counted.
  int sent() const { return wheels_.spoiled() + front_.spoiled() + rear_.spoiled(); }
  std::uint64_t counted() const;

 private:
  // Before the client's own publishers: roscpp would write a sequence number into what is no header.
  Topic<WheelTicks> wheels_{"wheel_ticks", 0};
  Topic<SteeringAngle> front_{"front_steering", 1};
  Topic<SteeringAngle> rear_{"rear_steering", 2};
  Topic<CalibrationState> calibration_{"calibration", 3};
  Topic<Pose> set_pose_{"set_pose", 4};
  Topic<tf2_msgs::TFMessage> tf_{"/tf", 5};
  OdometryClient client_{"", "/manager"};
  CalibrationState good_calibration_{perfectCar(parametersOf("/odometry"))};
  std::int64_t ticks_{1000};
};

std::uint64_t OdometryUnderFire::counted() const {
  const OdometryStatus& status = client_.status();
  return status.wheel_messages + status.steering_messages + status.dropped_stamp_zero +
         status.dropped_stamp_invalid + status.dropped_repeated + status.dropped_out_of_order +
         status.dropped_future + status.dropped_not_finite + status.dropped_steering_limit +
         status.dropped_no_steering + status.dropped_implausible + status.dropped_overflow;
}

/// Two steps of 10 mm that are 10 mm.
void expectSound(OdometryUnderFire& car) {
  ASSERT_TRUE(car.client().reset());
  car.calibrate();
  // Gains are taken again only if they differ by a tenth of their deviation, here 1e-5.
  const double tolerance = 1e-5 * 0.01;
  EXPECT_TRUE(waitFor([&] {
    if (!car.step()) return false;
    const auto before = car.client().odometry().back().pose.pose.position;
    if (!car.step()) return false;
    const auto after = car.client().odometry().back().pose.pose.position;
    return std::abs(std::hypot(after.x - before.x, after.y - before.y) - 0.01) < tolerance;
  }));
}

TEST(Fuzz, X1_odometry) {
  OdometryUnderFire car;
  ASSERT_TRUE(car.connect());
  const int process = alive("/manager");
  ASSERT_TRUE(car.step());
  const int batches = partOfAll(0.65) / (5 * kBatch);
  for (int batch = 0; batch < batches; ++batch) {
    for (int i = 0; i < kBatch; ++i) car.sendSpoiled();
    ASSERT_TRUE(car.step()) << "after batch " << batch;
  }
  // Lengths of the frame's name that are lies, and cuts, end in roscpp.
  EXPECT_GT(static_cast<double>(car.counted()), 0.8 * car.sent()) << "they arrive";
  EXPECT_EQ(alive("/manager"), process) << "invariant 5";
  expectSound(car);
}

/// Poses among them that are believed, so that steps may be of any length.
TEST(Fuzz, X1_odometry_with_poses) {
  OdometryUnderFire car;
  ASSERT_TRUE(car.connect());
  const int process = alive("/manager");
  car.client().allowJumps();
  ASSERT_TRUE(car.client().reset() && car.step());
  const int batches = partOfAll(0.1) / (6 * kBatch);
  for (int batch = 0; batch < batches; ++batch) {
    for (int i = 0; i < kBatch; ++i) {
      car.sendSpoiledPose();
      car.sendSpoiled();
    }
    ASSERT_TRUE(car.step()) << "after batch " << batch;
  }
  EXPECT_EQ(alive("/manager"), process) << "invariant 5";
  expectSound(car);
}

TEST(Fuzz, X1_joint_states) {
  OdometryClient client("joints", "/manager");
  Topic<sensor_msgs::JointState> joints("joints/joint_states", 6);
  ASSERT_TRUE(waitFor([&] { return joints.connected(); }));
  const int process = alive("/manager");
  double angle = 0.0;
  const auto step = [&](const ros::Time& stamp) { joints.send(jointState(angle, stamp)); };
  ASSERT_TRUE(goesOn(client, step));
  const int batches = partOfAll(0.1) / kBatch;
  for (int batch = 0; batch < batches; ++batch) {
    for (int i = 0; i < kBatch; ++i) joints.sendSpoiled(jointState(angle, ros::Time::now()));
    angle += 0.01;
    ASSERT_TRUE(goesOn(client, step)) << "after batch " << batch;
  }
  EXPECT_EQ(alive("/manager"), process) << "invariant 5";
}

/// Far enough in the past that no stamp of a drive lies in the future.
SimulatedDrive driveOf(const CalibrationClient& client) {
  SimulatedDriveSettings settings;
  settings.scenario = "slalom_eight";
  settings.duration = 10000.0;
  settings.seed = 1;
  settings.truth = false;
  const Time begin = toTime(ros::Time::now()).value() - durationFromSeconds(20000.0);
  return SimulatedDrive(parametersOf(client.node()), settings, begin);
}

/// What the node writes, before the pipe is full and it waits.
void readLog(CalibrationClient& client) { client.process().waitForOutput("no line holds this", 0.0); }

void expectGainsAreFound(CalibrationClient& client, SimulatedDrive& drive) {
  ASSERT_TRUE(client.drive(drive, 20.0));
  const CalibrationState& state = *client.state();
  EXPECT_NEAR(state.value[systematic::kRearRight], 1.02, 4.0 * state.deviation[systematic::kRearRight]);
  EXPECT_NEAR(state.value[systematic::kRearTrack], 1.03, 4.0 * state.deviation[systematic::kRearTrack]);
}

TEST(Fuzz, X1_calibration) {
  Topic<WheelTicks> wheels("fuzzed/wheel_ticks", 7);
  Topic<SteeringAngle> steering("fuzzed/front_steering", 8);
  Topic<Pose> laser("fuzzed/laser_pose", 9);
  CalibrationClient client("fuzzed");
  ASSERT_TRUE(client.start());
  const int process = alive(client.node());
  SimulatedDrive drive = driveOf(client);
  ASSERT_TRUE(client.drive(drive, 10.0));
  const int batches = partOfAll(0.1) / (3 * kBatch);
  for (int batch = 0; batch < batches; ++batch) {
    for (int i = 0; i < kBatch; ++i) {
      const ros::Time stamp = client.newestWheels() + ros::Duration(0, i + 1);
      wheels.sendSpoiledOfThePast(wheelTicks({0, 0, 0, 0}, stamp));
      steering.sendSpoiledOfThePast(steeringAngle(0.0, stamp));
      Pose pose = poseIn("map", stamp);
      // Elsewhere, they would agree with each other that the localiser has jumped.
      pose.pose.pose = client.odometry().back().pose.pose;
      laser.sendSpoiledOfThePast(pose);
    }
    readLog(client);
    // Spoiled nanoseconds that are believed keep good messages out for up to a second.
    ASSERT_TRUE(client.drive(drive, 2.0)) << "after batch " << batch;
  }
  EXPECT_EQ(alive(client.node()), process) << "invariant 5";
  EXPECT_TRUE(client.call("reset").success);
  client.announceNewRun();
  expectGainsAreFound(client, drive);
}

/// A calibration that searches /tf for its laser.
TEST(Fuzz, X1_laser_mount) {
  CalibrationClient client("mount");
  client.set("laser/frame", "the_mast");
  Topic<tf2_msgs::TFMessage> tf("/tf", 10);
  Topic<tf2_msgs::TFMessage> tf_static("/tf_static", 11);
  ASSERT_TRUE(client.start());
  const int process = alive(client.node());
  ASSERT_TRUE(waitFor([&] { return tf.connected(2) && tf_static.connected(); }));
  const double before = sizeOf(process).resident;
  for (int i = 0; i < partOfAll(0.05) / 2; ++i) {
    tf.sendSpoiled(link("four", "the_mast"));
    tf_static.sendSpoiled(link("four", "the_feet"));
    if (i % kBatch != 0) continue;
    readLog(client);
    client.call("save");  // an answer: what came before has been heard
  }
  EXPECT_EQ(alive(client.node()), process) << "invariant 5";
  // tf keeps every frame that was ever named; lengths that lie ask for gigabytes.
  EXPECT_LT(sizeOf(process).resident, before + 200.0) << "MB";
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  std::cout << "seed " << bs_car_odometry::testing::kSeed << std::endl;
  return bs_car_odometry::testing::runTests(argc, argv, "fuzz_test");
}
