// X1: every field of every input of the calibration spoiled, over a real master, between the messages of good
// drives.

#include "calibration_client.hpp"
#include "hostile_messages.hpp"
#include "hostile_topic.hpp"
#include "odometry_client.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

namespace bs_car_odometry::testing {
namespace {

/// A calibration, its process, and what is known of it from outside.
class CalibrationUnderFire {
 public:
  explicit CalibrationUnderFire(const std::string& name) : client_(name) {}

  bool start() {
    if (!client_.start()) return false;
    process_ = alive(client_.node());
    begin_ = ros::SteadyTime::now();
    return process_ != 0;
  }

  CalibrationClient& client() { return client_; }
  double megabytes() const { return sizeOf(process_).resident; }

  void readLog() { client_.process().readWritten(); }

  /// The process is the one that it was, and has not filled the log: each cause once in 5 s.
  void expectComposed() {
    EXPECT_EQ(alive(client_.node()), process_) << "invariant 5";
    readLog();
    constexpr double kCauses = 30;
    const std::string& output = client_.process().output();
    const auto lines = static_cast<double>(std::count(output.begin(), output.end(), '\n'));
    EXPECT_LT(lines, kCauses * ((ros::SteadyTime::now() - begin_).toSec() / 5.0 + 1.0));
    std::cout << lines << " lines in the log" << std::endl;
  }

 private:
  CalibrationClient client_;
  int process_{0};
  ros::SteadyTime begin_;
};

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

void expectGainsAreFound(CalibrationClient& client, SimulatedDrive& drive) {
  ASSERT_TRUE(client.drive(drive, 20.0));
  const CalibrationState& state = *client.state();
  EXPECT_NEAR(state.value[systematic::kRearRight], 1.02, 4.0 * state.deviation[systematic::kRearRight]);
  EXPECT_NEAR(state.value[systematic::kRearTrack], 1.03, 4.0 * state.deviation[systematic::kRearTrack]);
}

/// What a calibration hears while it calibrates.
struct HostileDrive {
  HostileTopic<WheelTicks> wheels{"fuzzed/wheel_ticks", 7};
  HostileTopic<SteeringAngle> steering{"fuzzed/front_steering", 8};
  HostileTopic<LaserMessage> laser{"fuzzed/laser_pose", 9};

  /// A batch of each, after what the client has sent.
  void sendSpoiled(const CalibrationClient& client) {
    for (int i = 0; i < kBatch; ++i) {
      const ros::Time stamp = client.newestWheels() + ros::Duration(0, i + 1);
      wheels.sendSpoiledOfThePast(wheelTicks({0, 0, 0, 0}, stamp));
      steering.sendSpoiledOfThePast(steeringAngle(0.0, stamp));
      LaserMessage pose = poseIn("map", stamp);
      // Elsewhere, they would agree with each other that the localiser has jumped.
      pose.pose.pose = client.newestLaser().pose.pose;
      laser.sendSpoiledOfThePast(pose);
    }
  }
};

TEST(Fuzz, X1_calibration) {
  HostileDrive hostile;
  CalibrationUnderFire calibration("fuzzed");
  CalibrationClient& client = calibration.client();
  ASSERT_TRUE(calibration.start());
  SimulatedDrive drive = driveOf(client);
  ASSERT_TRUE(client.drive(drive, 10.0));
  const int batches = spoiledBatches(0.1, 3 * kBatch);
  for (int batch = 0; batch < batches; ++batch) {
    hostile.sendSpoiled(client);
    calibration.readLog();
    // Stamps that were believed keep good messages out for up to half a second.
    ASSERT_TRUE(client.drive(drive, 2.0)) << "after batch " << batch;
  }
  calibration.expectComposed();
  EXPECT_TRUE(client.call("reset").success);
  client.announceNewRun();
  expectGainsAreFound(client, drive);
}

/// A calibration that searches /tf for its laser, of a car with two steering sensors.
TEST(Fuzz, X1_laser_mount) {
  HostileTopic<tf2_msgs::TFMessage> tf("/tf", 10);
  HostileTopic<tf2_msgs::TFMessage> tf_static("/tf_static", 11);
  HostileTopic<SteeringAngle> rear("mount/rear_steering", 12);
  CalibrationUnderFire calibration("mount");
  calibration.client().set("laser/frame", "the_mast");
  calibration.client().set("vehicle/rear_steering/source", "measured");
  ASSERT_TRUE(calibration.start());
  ASSERT_TRUE(waitFor([&] { return tf.connected() && tf_static.connected() && rear.connected(); }));
  const double before = calibration.megabytes();
  const int batches = spoiledBatches(0.05, 3 * kBatch);
  for (int batch = 0; batch < batches; ++batch) {
    for (int i = 0; i < kBatch; ++i) {
      tf.sendSpoiled(link("four", "the_mast"));
      tf_static.sendSpoiled(link("four", "the_feet"));
      rear.sendSpoiled(steeringAngle(0.0, ros::Time::now()));
    }
    calibration.readLog();
    calibration.client().call("save");  // an answer: what came before has been heard
  }
  calibration.expectComposed();
  // Lengths that lie ask for gigabytes; a thousand frames are kept.
  EXPECT_LT(calibration.megabytes(), before + 20.0);
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  std::cout << "seed " << bs_car_odometry::testing::kHostileSeed << std::endl;
  return bs_car_odometry::testing::runTests(argc, argv, "fuzz_calibration_test");
}
