#include "bs_car_odometry/simulation/scenario.hpp"

#include "bs_car_odometry/simulation/simulated_car.hpp"
#include "test_vehicles.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace bs_car_odometry::simulation {
namespace {

constexpr double kTwoPi = 6.283185307179586476925;

Pose poseAtTheEnd(const Scenario& scenario, const Vehicle& vehicle, Drivetrain drivetrain) {
  SimulationOptions options;
  options.drivetrain = drivetrain;
  options.substep = 0.0005;
  options.initial_pose = {1.0, -2.0, 0.3};
  SimulatedCar car(vehicle, asConfigured(vehicle), std::nullopt, scenario, options);
  car.advanceTo(scenario.duration);
  return car.truePose();
}

Vehicle ordinaryCar() {
  Vehicle vehicle = cycab();
  vehicle.wheelbase = 2.7;
  vehicle.rear_steering.coefficients = {0.0};
  return vehicle;
}

TEST(Scenario, unknownNameIsRefusedWithTheKnownOnes) {
  try {
    makeScenario("figure_4", cycab());
    FAIL() << "nothing thrown";
  } catch (const ScenarioError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("figure_4"));
    for (const std::string& name : scenarioNames()) EXPECT_THAT(error.what(), testing::HasSubstr(name));
  }
}

TEST(Scenario, speedFactorMustBePositive) {
  for (double factor : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(makeScenario("fig4", cycab(), Drivetrain::kSteered, factor), ScenarioError);
}

TEST(Scenario, fig4HasTheSpeedAndAngleOfThePaper) {
  const Scenario fig4 = makeScenario("fig4", cycab());
  EXPECT_EQ(fig4.duration, 15.0);
  EXPECT_DOUBLE_EQ(fig4.commandAt(0.5).speed, 0.675);
  EXPECT_DOUBLE_EQ(fig4.commandAt(7.0).speed, 1.35);
  EXPECT_DOUBLE_EQ(fig4.commandAt(14.6).speed, 0.675);
  EXPECT_NEAR(fig4.commandAt(3.0).front_angle, 0.035, 1e-15);
  EXPECT_NEAR(fig4.commandAt(7.0).front_angle, 0.27, 1e-15);
  EXPECT_NEAR(fig4.commandAt(10.5).front_angle, -0.05, 1e-15);
  EXPECT_NEAR(fig4.commandAt(13.5).front_angle, 0.03, 1e-15);
  EXPECT_NEAR(fig4.commandAt(15.0).front_angle, 0.0, 1e-15);
}

// No jump anywhere, also where the pattern begins anew: neighbouring commands 1 ms apart differ by what the
// steepest ramps (0.2 m/s in 0.5 s ... 1.35 m/s and 0.27 rad in 0.8 s) allow.
TEST(Scenario, commandsAreContinuousAcrossTheEndOfThePattern) {
  for (Drivetrain drivetrain : {Drivetrain::kSteered, Drivetrain::kDifferential})
    for (const std::string& name : scenarioNames()) {
      const Scenario scenario = makeScenario(name, robot(), drivetrain);
      Command before = scenario.commandAt(0.0);
      for (double t = 0.001; t < 2.1 * scenario.period; t += 0.001) {
        const Command now = scenario.commandAt(t);
        ASSERT_NEAR(now.speed, before.speed, 0.003) << name << " at " << t;
        ASSERT_NEAR(now.front_angle, before.front_angle, 0.001) << name << " at " << t;
        ASSERT_NEAR(now.yaw_rate, before.yaw_rate, 0.002) << name << " at " << t;
        before = now;
      }
    }
}

TEST(Scenario, loopsCloseForEveryVehicle) {
  Vehicle odd = oddCar(AxleGeometry::kAckermann);
  odd.rear_steering.coefficients[0] = 0.0;  // straight ahead at phi = 0
  Vehicle model = cycab();                  // 1:6, which turns far within a metre
  model.wheelbase = 0.2;
  model.base_link_x = 0.1;
  model.track = {0.2, 0.2};
  Vehicle contrary = cycab();  // turns right when its front wheels turn left
  contrary.rear_steering.coefficients = {0.0, 1.8};
  for (const char* name : {"rectangle", "square_loop"})
    for (const Vehicle& vehicle : {cycab(), ordinaryCar(), odd, model, contrary, robot()})
      for (Drivetrain drivetrain : {Drivetrain::kSteered, Drivetrain::kDifferential}) {
        if (drivetrain == Drivetrain::kDifferential && vehicle.hasEncoder(Wheel::kFrontLeft)) continue;
        for (double speed_factor : {1.0, 3.0}) {
          const Pose end =
              poseAtTheEnd(makeScenario(name, vehicle, drivetrain, speed_factor), vehicle, drivetrain);
          EXPECT_NEAR(end.x, 1.0, 1e-6) << name;
          EXPECT_NEAR(end.y, -2.0, 1e-6) << name;
          EXPECT_NEAR(end.yaw, 0.3 + kTwoPi, 1e-6) << name;
        }
      }
}

// P2's rectangle: halfway round the robot stands at the opposite corner, 10 m by 4.5 m away.
TEST(Scenario, theRobotsRectangleIs10By4AndAHalfMetres) {
  Scenario half = makeScenario("rectangle", robot(), Drivetrain::kDifferential);
  half.duration *= 0.5;
  const Pose pose = poseAtTheEnd(half, robot(), Drivetrain::kDifferential);
  EXPECT_NEAR(pose.x, 1.0 + 10.0 * std::cos(0.3) - 4.5 * std::sin(0.3), 1e-6);
  EXPECT_NEAR(pose.y, -2.0 + 10.0 * std::sin(0.3) + 4.5 * std::cos(0.3), 1e-6);
}

TEST(Scenario, squareLoopIsAbout99Metres) {
  const Scenario scenario = makeScenario("square_loop", cycab());
  EXPECT_NEAR(scenario.duration, 99.0, 0.5);  // at 1 m/s
}

TEST(Scenario, straightIs20MetresFromRestToRest) {
  const Scenario scenario = makeScenario("straight", cycab());
  const Pose end = poseAtTheEnd(scenario, cycab(), Drivetrain::kSteered);
  EXPECT_NEAR(std::hypot(end.x - 1.0, end.y + 2.0), 20.0, 1e-9);
  EXPECT_EQ(scenario.commandAt(0.0).speed, 0.0);
  EXPECT_EQ(scenario.commandAt(21.0).speed, 0.0);
}

TEST(Scenario, aCarThatOnlyCrabsCannotDriveALoop) {
  Vehicle crab = cycab();
  crab.rear_steering.coefficients = {0.0, 1.0};
  EXPECT_THROW(makeScenario("square_loop", crab), ScenarioError);
  EXPECT_NO_THROW(makeScenario("slalom_eight", crab));
}

TEST(Scenario, speedFactorKeepsTheTimesOrTheLengths) {
  EXPECT_EQ(makeScenario("slalom_eight", cycab(), Drivetrain::kSteered, 2.0).duration, 60.0);
  EXPECT_EQ(makeScenario("slalom_eight", cycab(), Drivetrain::kSteered, 2.0).commandAt(3.0).speed, 2.0);
  EXPECT_EQ(makeScenario("straight", cycab(), Drivetrain::kSteered, 2.0).duration, 11.0);
}

TEST(Drivetrain, isDifferentialOnlyWithAFixedRearAxleAloneInUse) {
  EXPECT_EQ(drivetrainOf(robot(), AxleSelection::kRear), Drivetrain::kDifferential);
  EXPECT_EQ(drivetrainOf(robot(), AxleSelection::kBoth), Drivetrain::kSteered);
  EXPECT_EQ(drivetrainOf(ordinaryCar(), AxleSelection::kRear), Drivetrain::kSteered);
  EXPECT_EQ(drivetrainOf(cycab(), AxleSelection::kRear), Drivetrain::kSteered);
}

// A differential robot follows the curvature of the car with the same steering command, tan(phi)/L.
TEST(Drivetrain, steeringCommandsBecomeYawRates) {
  const Vehicle vehicle = robot();
  const Pose steered = poseAtTheEnd(makeScenario("fig4", vehicle), vehicle, Drivetrain::kSteered);
  const Pose differential = poseAtTheEnd(makeScenario("fig4", vehicle), vehicle, Drivetrain::kDifferential);
  EXPECT_NEAR(steered.x, differential.x, 1e-9);
  EXPECT_NEAR(steered.y, differential.y, 1e-9);
  EXPECT_NEAR(steered.yaw, differential.yaw, 1e-9);
}

}  // namespace
}  // namespace bs_car_odometry::simulation
