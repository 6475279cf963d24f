#include "bs_car_odometry/ros/simulated_drive.hpp"

#include "bs_car_odometry/ros/conversions.hpp"
#include "test_vehicles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace bs_car_odometry {
namespace {

const Time kStart = timeFromNanoseconds(1600000000000000000);

Parameters parametersOf(const Vehicle& vehicle) {
  Parameters parameters;
  parameters.vehicle = vehicle;
  return parameters;
}

std::vector<SimulatedMessage> messagesOf(const Parameters& parameters,
                                         const SimulatedDriveSettings& settings) {
  SimulatedDrive drive(parameters, settings, kStart);
  std::vector<SimulatedMessage> messages;
  while (std::optional<SimulatedMessage> message = drive.next()) messages.push_back(*message);
  return messages;
}

std::ptrdiff_t countOf(const std::vector<SimulatedMessage>& messages, const std::string& topic) {
  return std::count_if(messages.begin(), messages.end(), [&](const auto& m) { return m.topic == topic; });
}

template <typename Message>
Message lastOf(const std::vector<SimulatedMessage>& messages, const std::string& topic) {
  const auto last =
      std::find_if(messages.rbegin(), messages.rend(), [&](const auto& m) { return m.topic == topic; });
  return std::get<Message>(last->content);
}

TEST(SimulatedDrive, messagesComeInTheOrderOfTheirReceipt) {
  SimulatedDriveSettings settings;
  settings.rate = 777.0;  // closer together than their delays
  settings.steering_rate = 1000.0;
  settings.laser_rate = 33.0;
  const std::vector<SimulatedMessage> messages = messagesOf(parametersOf(simulation::cycab()), settings);
  EXPECT_TRUE(std::is_sorted(messages.begin(), messages.end(),
                             [](const auto& a, const auto& b) { return a.receipt < b.receipt; }));
  EXPECT_EQ(countOf(messages, "wheel_ticks"), 777 * 15 + 1);
  EXPECT_EQ(countOf(messages, "ground_truth"), 777 * 15 + 1);
  EXPECT_EQ(countOf(messages, "front_steering"), 1000 * 15 + 1);
  EXPECT_EQ(countOf(messages, "laser_pose"), 33 * 15 + 1);
}

// Wheels 1 ms after their stamp, angles 2 ms: the odometry must wait for the angle with the wheels' stamp.
TEST(SimulatedDrive, anglesArriveAfterTheWheelsOfTheSameStamp) {
  for (const SimulatedMessage& message : messagesOf(parametersOf(simulation::cycab()), {})) {
    if (const auto* wheels = std::get_if<WheelTicks>(&message.content)) {
      EXPECT_EQ(message.receipt - toTime(wheels->header.stamp).value(), std::chrono::milliseconds(1));
    }
    if (const auto* angle = std::get_if<SteeringAngle>(&message.content)) {
      EXPECT_EQ(message.receipt - toTime(angle->header.stamp).value(), std::chrono::milliseconds(2));
    }
  }
}

TEST(SimulatedDrive, onlyWhatTheVehicleHasIsSent) {
  Parameters parameters = parametersOf(simulation::cycab());
  EXPECT_EQ(countOf(messagesOf(parameters, {}), "rear_steering"), 0);
  parameters.vehicle.rear_steering.source = RearSteering::Source::kMeasured;
  EXPECT_EQ(countOf(messagesOf(parameters, {}), "rear_steering"), 751);

  Parameters robot = parametersOf(simulation::robot());
  robot.odometry.axles = AxleSelection::kRear;
  SimulatedDriveSettings settings;
  settings.truth = false;
  settings.laser_rate = 0.0;
  EXPECT_EQ(messagesOf(robot, settings).size(), 751U);  // wheels alone
}

TEST(SimulatedDrive, startsAtTheInitialPoseAndTicksOnFromZero) {
  Parameters parameters = parametersOf(simulation::cycab());
  parameters.initial_pose.x = 3.0;
  parameters.initial_pose.yaw = -1.0;
  SimulatedDrive drive(parameters, {}, kStart);
  EXPECT_EQ(drive.car().truePose().x, 3.0);
  const SimulatedMessage first = drive.next().value();
  EXPECT_EQ(std::get<WheelTicks>(first.content).rear_left, 0);
  EXPECT_EQ(toTime(std::get<WheelTicks>(first.content).header.stamp).value(), kStart);
}

// Noise-free the nominal car is the true one, and the truth is its integral.
TEST(SimulatedDrive, truthAndTicksOfANoiseFreeDrive) {
  SimulatedDriveSettings settings;
  settings.scenario = "circle";
  settings.noise_free = true;
  Parameters parameters = parametersOf(simulation::cycab());
  const std::vector<SimulatedMessage> messages = messagesOf(parameters, settings);
  const double omega = 4.0 * std::sin(0.3) / 1.2;
  const double radius = 2.0 * std::cos(0.3) / omega;
  const auto truth = lastOf<nav_msgs::Odometry>(messages, "ground_truth");
  EXPECT_EQ(truth.header.frame_id, "odom");
  EXPECT_EQ(truth.child_frame_id, "base_link");
  EXPECT_NEAR(truth.pose.pose.position.x, radius * std::sin(30.0 * omega), 1e-8);
  EXPECT_NEAR(truth.twist.twist.linear.x, 2.0 * std::cos(0.3), 1e-12);
  EXPECT_NEAR(truth.twist.twist.linear.y, 0.0, 1e-12);
  EXPECT_NEAR(truth.twist.twist.angular.z, omega, 1e-12);
  EXPECT_EQ(lastOf<WheelTicks>(messages, "wheel_ticks").rear_right,
            std::llround(std::hypot(0.6, radius + 0.6) * 30.0 * omega / 1e-4));
  EXPECT_EQ(lastOf<SteeringAngle>(messages, "front_steering").angle, 0.3);
}

// p_P = p_base + R(theta) (x, y); a pose stamped t shows the car at t - time_offset.
TEST(SimulatedDrive, laserPosesAreThoseOfTheMountAndStampedLate) {
  SimulatedDriveSettings settings;
  settings.scenario = "straight";
  settings.noise_free = true;
  Parameters parameters = parametersOf(simulation::cycab());
  parameters.initial_pose.yaw = 1.5707963267948966;
  parameters.laser.x = 0.5;
  parameters.laser.time_offset = 0.04;
  const std::vector<SimulatedMessage> messages = messagesOf(parameters, settings);
  const auto pose = lastOf<geometry_msgs::PoseWithCovarianceStamped>(messages, "laser_pose");
  EXPECT_EQ(pose.header.frame_id, "map");
  EXPECT_EQ(toTime(pose.header.stamp).value() - kStart, std::chrono::milliseconds(21040));
  EXPECT_NEAR(pose.pose.pose.position.x, 0.0, 1e-9);
  EXPECT_NEAR(pose.pose.pose.position.y, 20.5, 1e-9);
  EXPECT_NEAR(toYaw(pose.pose.pose.orientation).value(), 1.5707963267948966, 1e-9);
  EXPECT_NEAR(pose.pose.covariance[0], 4e-4, 1e-15);
  EXPECT_NEAR(pose.pose.covariance[35], 2.5e-5, 1e-15);
}

TEST(SimulatedDrive, aLongerDriveRepeatsTheScenario) {
  SimulatedDriveSettings settings;
  settings.scenario = "straight";
  settings.noise_free = true;
  settings.duration = 63.0;
  const std::vector<SimulatedMessage> messages = messagesOf(parametersOf(simulation::cycab()), settings);
  EXPECT_NEAR(lastOf<nav_msgs::Odometry>(messages, "ground_truth").pose.pose.position.x, 60.0, 1e-8);
}

TEST(SimulatedDrive, refusesSettingsThatMakeNoSense) {
  const Parameters parameters = parametersOf(simulation::cycab());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](auto&& change) {
    SimulatedDriveSettings settings;
    change(settings);
    EXPECT_THROW(SimulatedDrive(parameters, settings, kStart), std::invalid_argument);
  };
  refused([](auto& s) { s.rate = 0.0; });
  refused([&](auto& s) { s.rate = nan; });
  refused([](auto& s) { s.rate = 1e9; });
  refused([](auto& s) { s.steering_rate = -1.0; });
  refused([&](auto& s) { s.laser_rate = nan; });
  refused([](auto& s) { s.duration = -1.0; });
  refused([](auto& s) { s.speed_factor = 0.0; });
  refused([](auto& s) { s.scenario = "figure_4"; });
  refused([](auto& s) { s.noise_free = s.draw_gains = true; });
}

TEST(SimulatedDrive, drawnParametersDifferFromSeedToSeed) {
  SimulatedDriveSettings settings;
  settings.draw_gains = true;
  const Parameters parameters = parametersOf(simulation::cycab());
  const double first = SimulatedDrive(parameters, settings, kStart).truth().gains.rear.k_b;
  EXPECT_EQ(first, SimulatedDrive(parameters, settings, kStart).truth().gains.rear.k_b);
  settings.seed = 2;
  EXPECT_NE(first, SimulatedDrive(parameters, settings, kStart).truth().gains.rear.k_b);
}

}  // namespace
}  // namespace bs_car_odometry
