// Joint states as readings of the odometry, without a master.

#include "bs_car_odometry/ros/odometry_adapter.hpp"
#include "bs_car_odometry/core/kinematics.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace bs_car_odometry
