// Joint states as readings of the odometry, without a master.

#include "bs_car_odometry/ros/odometry_adapter.hpp"
#include "bs_car_odometry/core/kinematics.hpp"
#include "bs_car_odometry/ros/clock_watch.hpp"

#include "support/figure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace bs_car_odometry {
namespace {

using Joints = std::vector<std::pair<std::string, double>>;

RawJointState jointState(double stamp, const Joints& joints) {
  sensor_msgs::JointState message;
  message.header.stamp = ros::Time(stamp);
  for (const auto& [name, position] : joints) {
    message.name.push_back(name);
    message.position.push_back(position);
  }
  RawJointState raw;
  raw.bytes.resize(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(raw.bytes.data(), static_cast<std::uint32_t>(raw.bytes.size()));
  ros::serialization::serialize(stream, message);
  return raw;
}

/// A Cycab with wheels of 0.2 m radius that speaks in joint states.
Parameters cycab() {
  Parameters parameters;
  parameters.input = InputSource::kJointStates;
  parameters.vehicle.wheelbase = 1.2;
  parameters.vehicle.track = {1.2, 1.2};
  parameters.vehicle.metres_per_tick = {{0.2, 0.2, 0.2, 0.2}};
  parameters.joints.wheels = {{"fl", "fr", "rl", "rr"}};
  parameters.joints.steering.front = {"front"};
  return parameters;
}

TEST(JointStates, oneAxleNeedsOnlyItsOwnWheels) {
  for (const Axle axle : kAllAxles) {
    Parameters parameters = cycab();
    parameters.odometry.axles = axle == Axle::kFront ? AxleSelection::kFront : AxleSelection::kRear;
    for (const Wheel wheel : {leftWheel(axle == Axle::kFront ? Axle::kRear : Axle::kFront),
                              rightWheel(axle == Axle::kFront ? Axle::kRear : Axle::kFront)})
      parameters.joints.wheels[wheel].clear();
    OdometryAdapter adapter(parameters);
    std::optional<OdometryUpdate> newest;
    for (int i = 0; i <= 10; ++i) {
      const double stamp = 100.0 + 0.1 * i;
      const JointVerdicts verdicts =
          adapter.add(jointState(stamp, {{parameters.joints.wheels[leftWheel(axle)], 0.5 * i},
                                         {parameters.joints.wheels[rightWheel(axle)], 0.5 * i},
                                         {"front", 0.0}}),
                      ros::Time(stamp));
      EXPECT_EQ(verdicts.worst(), Verdict::kAccepted);
      ASSERT_TRUE(verdicts.wheels);
      newest = adapter.next(ros::Time(stamp));
      ASSERT_TRUE(newest);
    }
    EXPECT_NEAR(newest->estimate.pose.x, 1.0, 1e-8) << "ten steps of 0.5 rad at 0.2 m";
  }
}

TEST(JointStates, aMessageWithoutWheelsIsNoWheelMessage) {
  OdometryAdapter adapter(cycab());
  const JointVerdicts verdicts = adapter.add(jointState(100.0, {{"front", 0.1}}), ros::Time(100.0));
  EXPECT_FALSE(verdicts.wheels);
  EXPECT_EQ(adapter.pipeline().counts().steering_messages, 1u);
}

/// With a polynomial rear law only the front reading counts.
TEST(JointStates, jointsOfAnAxleThatIsNotNeededAreNotRead) {
  Parameters parameters = cycab();
  parameters.joints.steering.rear = {"rear"};
  OdometryAdapter adapter(parameters);
  const JointVerdicts verdicts =
      adapter.add(jointState(100.0, {{"front", 0.1}, {"rear", std::nan("")}}), ros::Time(100.0));
  EXPECT_EQ(verdicts.worst(), Verdict::kAccepted);
  EXPECT_EQ(adapter.pipeline().counts().steering_messages, 1u);
  EXPECT_EQ(adapter.pipeline().counts()[Verdict::kNotFinite], 0u);
}

/// The wheels of the rear axle give its angle only with the true angle of the front one, whatever its sensor
/// reads.
TEST(JointStates, wheelJointsAreReadWithTheOtherAxlesCalibratedAngle) {
  const SteeringAngles truth{0.3, 0.226};
  for (const double scale : {1.0, -1.0, 1.0 / 16.0}) {
    Vehicle vehicle = cycab().vehicle;
    vehicle.rear_steering.source = RearSteering::Source::kMeasured;
    vehicle.steering.front = {scale, 0.02};
    JointNames joints;
    joints.steering.front = {"front"};
    joints.steering.rear = {"left", "right"};
    JointPositions positions;
    positions.positions = {{"front", (truth.front - 0.02) / scale},
                           {"left", wheelDirection(vehicle, Wheel::kRearLeft, truth)},
                           {"right", wheelDirection(vehicle, Wheel::kRearRight, truth)}};
    const PerAxle<std::optional<double>> readings = axleReadings(vehicle, joints, positions);
    ASSERT_TRUE(readings.rear);
    EXPECT_NEAR(*readings.rear, truth.rear, 1e-12) << "scale " << scale;
  }
}

Parameters cycabWithTicks() {
  Parameters parameters = cycab();
  parameters.input = InputSource::kWheelTicks;
  parameters.vehicle.metres_per_tick = {{1e-4, 1e-4, 1e-4, 1e-4}};
  return parameters;
}

/// Messages of drivers with a name, each at its time.
class Drivers {
 public:
  Verdict wheels(const std::string& driver, double time, std::int64_t ticks) {
    WheelTicks message;
    message.header.stamp = ros::Time(time);
    message.front_left = message.front_right = message.rear_left = message.rear_right = ticks;
    return adapter_.add(message, ros::Time(time), sender(driver, time));
  }
  Verdict steering(const std::string& driver, double time, double angle) {
    SteeringAngle message;
    message.header.stamp = ros::Time(time);
    message.angle = angle;
    return adapter_.add(Axle::kFront, message, ros::Time(time), sender(driver, time));
  }
  OdometryAdapter& adapter() { return adapter_; }

 private:
  static Sender sender(const std::string& name, double time) { return {name, *toTime(ros::Time(time))}; }
  OdometryAdapter adapter_{cycabWithTicks()};
};

TEST(Publishers, E10_the_first_one_is_kept) {
  Drivers drivers;
  for (int i = 0; i < 100; ++i) {
    const double time = 100.0 + 0.02 * i;
    EXPECT_EQ(drivers.wheels("/driver", time, 100 * i), Verdict::kAccepted);
    EXPECT_EQ(drivers.wheels("/rival", time + 0.005, 5000 - i), Verdict::kRivalPublisher);
    EXPECT_EQ(drivers.steering("/steering", time, 0.0), Verdict::kAccepted) << "inputs are kept apart";
    EXPECT_EQ(drivers.steering("/rival", time + 0.005, 1.0), Verdict::kRivalPublisher);
    const auto update = drivers.adapter().next(ros::Time(time));
    ASSERT_TRUE(update);
    EXPECT_NEAR(update->estimate.pose.x, 0.01 * i, 1e-9);
  }
  EXPECT_EQ(drivers.adapter().pipeline().counts()[Verdict::kRivalPublisher], 200u);
}

TEST(Publishers, E10_a_driver_that_is_started_again_is_heard) {
  Drivers drivers;
  EXPECT_EQ(drivers.wheels("/driver", 100.0, 0), Verdict::kAccepted);
  EXPECT_EQ(drivers.wheels("/driver", 100.5, 0), Verdict::kAccepted) << "with its old name at once";
  EXPECT_EQ(drivers.wheels("/driver_2", 101.4, 0), Verdict::kRivalPublisher);
  EXPECT_EQ(drivers.wheels("/driver_2", 101.5, 0), Verdict::kAccepted) << "with another after a second";
  EXPECT_EQ(drivers.wheels("/driver", 101.6, 0), Verdict::kRivalPublisher) << "which is kept then";
}

TEST(Publishers, E10_only_what_is_taken_gives_the_right_to_be_heard) {
  Drivers drivers;
  EXPECT_EQ(drivers.steering("/broken", 100.0, std::nan("")), Verdict::kNotFinite);
  EXPECT_EQ(drivers.steering("/sound", 100.1, 0.1), Verdict::kAccepted);
  EXPECT_EQ(drivers.steering("/broken", 100.2, 0.2), Verdict::kRivalPublisher);
}

TEST(Publishers, E10_a_clock_that_goes_back_does_not_shut_anybody_out) {
  Drivers drivers;
  EXPECT_EQ(drivers.steering("/player_1", 100.0, 0.1), Verdict::kAccepted);
  drivers.adapter().clockWentBack(true);
  EXPECT_EQ(drivers.steering("/player_2", 50.0, 0.1), Verdict::kAccepted);
}

/// Wheels at 50 Hz and steering at 20 Hz, stamped and received by a clock that goes back by 2 s.
TEST(Clock, T6_two_seconds_back_are_no_silence_and_no_step) {
  Drivers drivers;
  ClockWatch watch(InputLimits().max_future);
  double published = 0.0;
  double silence = 0.0;
  for (int i = 0; i <= 400; ++i) {
    const double time = 0.01 * i;
    const double clock = 100.0 + time - (i > 200 ? 2.0 : 0.0);
    if (watch.wentBack(ros::Time(clock))) drivers.adapter().clockWentBack(false);
    if (i % 5 == 0) drivers.steering("/driver", clock, 0.0);
    if (i % 2 == 0) drivers.wheels("/driver", clock, 50 * i);
    while (const auto update = drivers.adapter().next(ros::Time(clock))) {
      // The counters of the newest message, or of the one before that has waited for its angle.
      EXPECT_NEAR(update->estimate.pose.x, 5e-3 * i, 0.01 + 1e-9) << "at " << time << " s";
      silence = std::max(silence, time - published);
      published = time;
    }
  }
  EXPECT_GT(published, 3.9);
  EXPECT_LT(silence, 0.2);
  recordFigure("2 s back: silent for %.2f s", silence);
  EXPECT_GT(silence, 0.0);
}

/// One driver of the wheels and another one of the steering share the topic.
TEST(Publishers, E10_joint_states_are_several_inputs) {
  OdometryAdapter adapter(cycab());
  const Joints wheels{{"fl", 0.0}, {"fr", 0.0}, {"rl", 0.0}, {"rr", 0.0}};
  const auto add = [&](const std::string& driver, double time, const Joints& joints) {
    return adapter.add(jointState(time, joints), ros::Time(time), {driver, *toTime(ros::Time(time))}).worst();
  };
  EXPECT_EQ(add("/wheels", 100.0, wheels), Verdict::kAccepted);
  EXPECT_EQ(add("/steering", 100.0, {{"front", 0.1}}), Verdict::kAccepted);
  EXPECT_EQ(add("/arm", 100.0, {{"elbow", 0.1}}), Verdict::kAccepted) << "nothing of ours";
  EXPECT_EQ(add("/rival", 100.1, {{"front", 0.2}}), Verdict::kRivalPublisher);
  EXPECT_EQ(add("/rival", 100.2, wheels), Verdict::kRivalPublisher);
  EXPECT_EQ(add("/wheels", 100.3, wheels), Verdict::kAccepted);
}

}  // namespace
}  // namespace bs_car_odometry
