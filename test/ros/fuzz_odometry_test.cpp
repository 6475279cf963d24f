// X1: every field of every input of the odometry spoiled, over a real master, between the messages of good
// drives.

#include "calibration_client.hpp"
#include "hostile_messages.hpp"
#include "hostile_topic.hpp"
#include "odometry_client.hpp"

#include "bs_car_odometry/calibration/result_file.hpp"

#include <gtest/gtest.h>
#include <sensor_msgs/JointState.h>

#include <cmath>
#include <iostream>

namespace bs_car_odometry::testing {
namespace {

using Pose = geometry_msgs::PoseWithCovarianceStamped;

/// Lines that a manager may have written in this time [s]: each cause of each of its nodelets once in 5 s.
double mostLines(double seconds) {
  constexpr double kCauses = 2 * 30;
  return kCauses * (seconds / 5.0 + 1.0);
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
      for (HostileTopic<SteeringAngle>* steering : {&front_, &rear_})
        steering->send(steeringAngle(0.0, stamp));
      wheels_.send(wheelTicks({ticks_, ticks_, ticks_, ticks_}, stamp));
    });
  }

  /// With the gains that it had, which spoiled messages may have changed.
  void calibrate() { calibration_.send(good_calibration_); }

  /// The process is the one that it was, and has not filled the log.
  void expectComposed() const {
    EXPECT_TRUE(client_.processLives()) << "invariant 5";
    const double lines = static_cast<double>(log_.countOf("/manager"));
    EXPECT_LT(lines, mostLines((ros::SteadyTime::now() - begin_).toSec()));
    std::cout << lines << " lines in the log" << std::endl;
  }

  OdometryClient& client() { return client_; }
  /// Messages of wheels and steering that were sent spoiled, and those that the odometry counted.
  int sent() const { return wheels_.spoiled() + front_.spoiled() + rear_.spoiled(); }
  std::uint64_t counted() const;

 private:
  // Before the client's own publishers: roscpp would write a sequence number into what is no header.
  HostileTopic<WheelTicks> wheels_{"wheel_ticks", 0};
  HostileTopic<SteeringAngle> front_{"front_steering", 1};
  HostileTopic<SteeringAngle> rear_{"rear_steering", 2};
  HostileTopic<CalibrationState> calibration_{"calibration", 3};
  HostileTopic<Pose> set_pose_{"set_pose", 4};
  HostileTopic<tf2_msgs::TFMessage> tf_{"/tf", 5};
  OdometryClient client_{"", "/manager"};
  LogListener log_;
  ros::SteadyTime begin_{ros::SteadyTime::now()};
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
  ASSERT_TRUE(car.step());
  const int batches = spoiledBatches(0.65, 5 * kBatch);
  for (int batch = 0; batch < batches; ++batch) {
    for (int i = 0; i < kBatch; ++i) car.sendSpoiled();
    ASSERT_TRUE(car.step()) << "after batch " << batch;
  }
  // Lengths of the frame's name that are lies, and cuts, end in roscpp.
  EXPECT_GT(static_cast<double>(car.counted()), 0.8 * car.sent()) << "they arrive";
  car.expectComposed();
  expectSound(car);
}

/// Poses among them that are believed, so that steps may be of any length.
TEST(Fuzz, X1_odometry_with_poses) {
  OdometryUnderFire car;
  ASSERT_TRUE(car.connect());
  car.client().allowJumps();
  ASSERT_TRUE(car.client().reset() && car.step());
  const int batches = spoiledBatches(0.1, 6 * kBatch);
  for (int batch = 0; batch < batches; ++batch) {
    for (int i = 0; i < kBatch; ++i) {
      car.sendSpoiledPose();
      car.sendSpoiled();
    }
    ASSERT_TRUE(car.step()) << "after batch " << batch;
  }
  car.expectComposed();
  expectSound(car);
}

TEST(Fuzz, X1_joint_states) {
  OdometryClient client("joints", "/manager");
  HostileTopic<sensor_msgs::JointState> joints("joints/joint_states", 6);
  ASSERT_TRUE(waitFor([&] { return joints.connected(); }));
  const int process = alive("/manager");
  double angle = 0.0;
  const auto step = [&](const ros::Time& stamp) { joints.send(jointState(angle, stamp)); };
  ASSERT_TRUE(goesOn(client, step));
  const int batches = spoiledBatches(0.1, kBatch);
  for (int batch = 0; batch < batches; ++batch) {
    for (int i = 0; i < kBatch; ++i) joints.sendSpoiled(jointState(angle, ros::Time::now()));
    angle += 0.01;
    ASSERT_TRUE(goesOn(client, step)) << "after batch " << batch;
  }
  EXPECT_EQ(alive("/manager"), process) << "invariant 5";
}

}  // namespace
}  // namespace bs_car_odometry::testing

int main(int argc, char** argv) {
  std::cout << "seed " << bs_car_odometry::testing::kHostileSeed << std::endl;
  return bs_car_odometry::testing::runTests(argc, argv, "fuzz_odometry_test");
}
