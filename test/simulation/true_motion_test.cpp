#include "bs_car_odometry/simulation/true_motion.hpp"

#include "test_vehicles.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace bs_car_odometry::simulation {
namespace {

constexpr double kTwoPi = 6.283185307179586476925;
constexpr double kPrinted = 5e-10;  // half a unit of the ninth digit behind the point

TrueMotion motionOf(const Vehicle& vehicle, const Scenario& scenario, double substep = 0.001,
                    Drivetrain drivetrain = Drivetrain::kSteered, const TrueMotion::Noise& noise = {},
                    std::uint64_t seed = 1) {
  return {TrueBody(vehicle, asConfigured(vehicle), drivetrain), scenario, noise, seed, substep, Pose{}};
}

TrueMotion driven(const Vehicle& vehicle, const Scenario& scenario, double substep = 0.001,
                  Drivetrain drivetrain = Drivetrain::kSteered) {
  TrueMotion motion = motionOf(vehicle, scenario, substep, drivetrain);
  motion.advanceTo(scenario.duration);
  return motion;
}

// --- instants ------------------------------------------------------------------------------------------

// phi_f = 0.25, phi_r = -0.2, a = +/-0.6, B = 1.2, vx = 1 (docs/model.md, section 9, T14).
TEST(TrueBody, wheelsHaveTheDirectionsAndSpeedsOfK3) {
  Vehicle vehicle = cycab();
  vehicle.rear_steering.coefficients = {0.0, -0.8};
  const TrueBody body(vehicle, asConfigured(vehicle), Drivetrain::kSteered);
  const Instant instant = body.instant({1.0 / std::cos(0.2), 0.25, 0.0}, 0.0);
  const Twist twist = body.twist(instant);
  EXPECT_NEAR(twist.vx, 1.0, 1e-12);
  EXPECT_NEAR(twist.yaw_rate, 0.381709963941, 1e-12);
  EXPECT_NEAR(twist.vy, 0.0263159428562, 1e-12);
  const PerWheel<double> directions{{0.319823863108, 0.204845439636, -0.257107942959, -0.163463844478}};
  const PerWheel<double> speeds{{0.812157890295, 1.25527062908, 0.797177709505, 1.24563084981}};
  for (Wheel wheel : kAllWheels) {
    EXPECT_NEAR(std::atan2(instant.wheel[wheel].sin, instant.wheel[wheel].cos), directions[wheel], 1e-11);
    EXPECT_NEAR(body.rollingSpeed(wheel, instant, twist), speeds[wheel], 1e-11);
  }
}

// With slip the axle middles move sideways by just that much, and the rear one still at V along its angle.
TEST(TrueBody, axleMiddlesSlipByWhatIsAsked) {
  const Vehicle vehicle = oddCar(AxleGeometry::kAckermann);
  const TrueBody body(vehicle, asConfigured(vehicle), Drivetrain::kSteered);
  for (double phi : {-0.6, -0.1, 0.0, 0.3, 0.9}) {
    const Instant instant = body.instant({1.7, phi, 0.0}, 0.01);
    const double phi_r = vehicle.rear_steering.angle(phi) + 0.01;
    const Twist t = body.twist(instant, {0.03, -0.05});
    const double v_Fy = t.vy + 1.3 * t.yaw_rate;
    const double v_Ry = t.vy - 0.4 * t.yaw_rate;
    EXPECT_NEAR(-std::sin(phi) * t.vx + std::cos(phi) * v_Fy, 0.03, 1e-14);
    EXPECT_NEAR(-std::sin(phi_r) * t.vx + std::cos(phi_r) * v_Ry, -0.05, 1e-14);
    EXPECT_NEAR(std::cos(phi_r) * t.vx + std::sin(phi_r) * v_Ry, 1.7, 1e-14);
  }
}

TEST(TrueBody, aFixedWheelRollsBackwardsWhenTheCarTurnsAboutAPointBesideIt) {
  Vehicle vehicle = cycab();
  vehicle.rear_steering.coefficients = {0.0};
  const TrueBody body(vehicle, asConfigured(vehicle), Drivetrain::kSteered);
  const Instant instant =
      body.instant({1.0, std::atan(1.2 / 0.4), 0.0}, 0.0);  // turns about 0.4 m to the left
  const Twist twist = body.twist(instant);
  EXPECT_NEAR(body.rollingSpeed(Wheel::kRearLeft, instant, twist), -0.5, 1e-12);
  EXPECT_NEAR(body.rollingSpeed(Wheel::kRearRight, instant, twist), 2.5, 1e-12);
}

// --- closed forms --------------------------------------------------------------------------------------

TEST(TrueMotion, straight) {
  for (AxleGeometry geometry : {AxleGeometry::kAckermann, AxleGeometry::kPivot}) {
    Vehicle vehicle = oddCar(geometry);
    vehicle.rear_steering.coefficients = {0.0, -0.7};
    const TrueMotion motion = driven(vehicle, makeScenario("straight", vehicle));
    EXPECT_NEAR(motion.pose().x, 20.0, 1e-9);
    EXPECT_NEAR(motion.pose().y, 0.0, 1e-12);
    EXPECT_NEAR(motion.pose().yaw, 0.0, 1e-12);
    for (Wheel wheel : kAllWheels) EXPECT_NEAR(motion.travel(wheel), 20.0, 1e-9);
  }
}

// Every point turns about the centre C = (-vy/omega, vx/omega) of base_link; an Ackermann wheel rolls
// |contact - C| times the angle, hub offset or not.
TEST(TrueMotion, circle) {
  const Vehicle vehicle = oddCar(AxleGeometry::kAckermann);
  const TrueMotion motion = driven(vehicle, makeScenario("circle", vehicle));
  const double phi_r = vehicle.rear_steering.angle(0.3);
  const double vx = 2.0 * std::cos(phi_r);
  const double omega = vx * (std::tan(0.3) - std::tan(phi_r)) / 1.7;
  const double vy = 2.0 * std::sin(phi_r) + 0.4 * omega;
  const double centre_x = -vy / omega;
  const double centre_y = vx / omega;
  const double angle = 30.0 * omega;
  EXPECT_NEAR(motion.pose().yaw / angle, 1.0, 1e-11);
  EXPECT_NEAR(motion.pose().x, centre_x - std::cos(angle) * centre_x + std::sin(angle) * centre_y, 1e-9);
  EXPECT_NEAR(motion.pose().y, centre_y - std::sin(angle) * centre_x - std::cos(angle) * centre_y, 1e-9);
  for (Wheel wheel : kAllWheels) {
    const double side = isLeft(wheel) ? 1.0 : -1.0;
    const double half = 0.5 * vehicle.track[axleOf(wheel)];
    const double hub = vehicle.hub_offset[axleOf(wheel)];
    const double kingpin =
        std::hypot(vehicle.axleX(axleOf(wheel)) - centre_x, side * (half - hub) - centre_y);
    EXPECT_NEAR(motion.travel(wheel) / ((kingpin - side * hub) * angle), 1.0, 1e-11) << name(wheel);
  }
}

TEST(TrueMotion, circleOfTheCycab) {
  const Vehicle vehicle = cycab();
  const TrueMotion motion = driven(vehicle, makeScenario("circle", vehicle));
  const double omega = 2.0 * 2.0 * std::sin(0.3) / 1.2;  // omega = 2 V_r sin(phi)/L
  const double radius = 2.0 * std::cos(0.3) / omega;
  EXPECT_NEAR(motion.pose().yaw, 30.0 * omega, 1e-9);
  EXPECT_NEAR(motion.pose().x, radius * std::sin(30.0 * omega), 1e-9);
  EXPECT_NEAR(motion.pose().y, radius * (1.0 - std::cos(30.0 * omega)), 1e-9);
  EXPECT_NEAR(motion.travel(Wheel::kRearRight), std::hypot(0.6, radius + 0.6) * 30.0 * omega, 1e-8);
  EXPECT_NEAR(motion.travel(Wheel::kFrontLeft), std::hypot(0.6, radius - 0.6) * 30.0 * omega, 1e-8);
}

TEST(TrueMotion, crabbing) {
  for (AxleGeometry geometry : {AxleGeometry::kAckermann, AxleGeometry::kPivot}) {
    Vehicle vehicle = cycab();
    vehicle.axle_geometry = geometry;
    vehicle.rear_steering.coefficients = {0.0, 1.0};
    const TrueMotion motion = driven(vehicle, constantDrive(10.0, 0.8, 0.35));
    EXPECT_NEAR(motion.pose().x, 8.0 * std::cos(0.35), 1e-11);
    EXPECT_NEAR(motion.pose().y, 8.0 * std::sin(0.35), 1e-11);
    EXPECT_NEAR(motion.pose().yaw, 0.0, 1e-13);
    for (Wheel wheel : kAllWheels) EXPECT_NEAR(motion.travel(wheel), 8.0, 1e-11);
  }
}

TEST(TrueMotion, turningOnTheSpot) {
  const TrueMotion motion =
      driven(robot(), constantDrive(5.0, 0.0, 0.0, 0.7), 0.001, Drivetrain::kDifferential);
  EXPECT_NEAR(motion.pose().yaw, 3.5, 1e-12);
  EXPECT_NEAR(motion.pose().x, 0.0, 1e-13);
  EXPECT_NEAR(motion.travel(Wheel::kRearRight), 0.2 * 3.5, 1e-12);
  EXPECT_NEAR(motion.travel(Wheel::kRearLeft), -0.2 * 3.5, 1e-12);
}

// A robot whose base_link is 0.25 m ahead of its axle turns about the axle.
TEST(TrueMotion, turningOnTheSpotMovesABaseLinkAheadOfTheAxle) {
  Vehicle vehicle = robot();
  vehicle.base_link_x = 0.25;
  const TrueMotion motion =
      driven(vehicle, constantDrive(5.0, 0.0, 0.0, 0.7), 0.001, Drivetrain::kDifferential);
  EXPECT_NEAR(motion.pose().x, -0.25 + 0.25 * std::cos(3.5), 1e-12);
  EXPECT_NEAR(motion.pose().y, 0.25 * std::sin(3.5), 1e-12);
}

TEST(TrueMotion, thereAndBackTheSameWay) {
  const Vehicle vehicle = oddCar(AxleGeometry::kAckermann);
  const auto there_and_back = [](double t) {
    return Command{std::cos(kTwoPi * t / 20.0), 0.3 * std::cos(kTwoPi * t / 10.0), 0.0};
  };
  const TrueMotion motion = driven(vehicle, drive(20.0, there_and_back));
  EXPECT_NEAR(motion.pose().x, 0.0, 1e-11);
  EXPECT_NEAR(motion.pose().y, 0.0, 1e-11);
  EXPECT_NEAR(motion.pose().yaw, 0.0, 1e-11);
  for (Wheel wheel : kAllWheels) EXPECT_NEAR(motion.travel(wheel), 0.0, 1e-11);
}

// --- hub offset ----------------------------------------------------------------------------------------

TEST(TrueMotion, steeringAtAStandstillRollsTheWheelsAboutTheirKingpins) {
  Vehicle vehicle = cycab();
  vehicle.axle_geometry = AxleGeometry::kPivot;
  vehicle.hub_offset = {0.07, 0.05};
  const auto steer = [](double t) { return Command{0.0, 0.1 * t, 0.0}; };
  TrueMotion motion = motionOf(vehicle, {"test", 3.0, 10.0, steer, {}});
  motion.advanceTo(3.0);
  EXPECT_NEAR(motion.travel(Wheel::kFrontLeft), -0.07 * 0.3, 1e-14);
  EXPECT_NEAR(motion.travel(Wheel::kFrontRight), 0.07 * 0.3, 1e-14);
  EXPECT_NEAR(motion.travel(Wheel::kRearLeft), 0.05 * 0.3, 1e-14);
  EXPECT_NEAR(motion.travel(Wheel::kRearRight), -0.05 * 0.3, 1e-14);
}

// (H), model A at constant angle: S_r - S_l = dth ((B - 2h) cos(alpha) + 2h), S_r + S_l = 2 dS.
TEST(TrueMotion, pivotAxleWithHubOffsetFollowsH) {
  const Vehicle vehicle = oddCar(AxleGeometry::kPivot);
  const TrueMotion motion = driven(vehicle, constantDrive(10.0, 1.1, 0.3));
  const double alpha = vehicle.rear_steering.angle(0.3);
  const double right = motion.travel(Wheel::kRearRight);
  const double left = motion.travel(Wheel::kRearLeft);
  EXPECT_NEAR(right - left, motion.pose().yaw * ((1.1 + 0.06) * std::cos(alpha) - 0.06), 1e-11);
  EXPECT_NEAR(right + left, 2.0 * 11.0, 1e-11);
}

/// Travel of a wheel's contact point along its rolling direction, straight from the definition: midpoint
/// rule, the carrier's rate by a central difference of (K3).
double travelByDefinition(Wheel wheel, const Vehicle& vehicle, const Scenario& scenario) {
  const Axle axle = axleOf(wheel);
  const double e = isLeft(wheel) ? 1.0 : -1.0;
  const double h = vehicle.hub_offset[axle];
  const double x = vehicle.axleX(axle);
  const double y = e * (0.5 * vehicle.track[axle] - h);
  const auto curvature = [&](double phi) {
    return (std::tan(phi) - std::tan(vehicle.rear_steering.angle(phi))) / vehicle.wheelbase;
  };
  const auto sideslip = [&](double phi) {
    return std::tan(vehicle.rear_steering.angle(phi)) + vehicle.base_link_x * curvature(phi);
  };
  const auto direction = [&](double t) {
    const double phi = scenario.commandAt(t).front_angle;
    if (vehicle.axle_geometry == AxleGeometry::kPivot)
      return axle == Axle::kFront ? phi : vehicle.rear_steering.angle(phi);
    return std::atan2(sideslip(phi) + curvature(phi) * x, 1.0 - curvature(phi) * y);
  };
  constexpr int kSteps = 40000;
  const double dt = scenario.duration / kSteps;
  double travel = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = (i + 0.5) * dt;
    const Command command = scenario.commandAt(t);
    const double vx = command.speed * std::cos(vehicle.rear_steering.angle(command.front_angle));
    const double omega = vx * curvature(command.front_angle);
    const double vy = vx * sideslip(command.front_angle);
    const double delta = direction(t);
    const double carrier_rate = omega + (direction(t + 1e-5) - direction(t - 1e-5)) / 2e-5;
    // contact = kingpin + e h (-sin(delta), cos(delta)), which moves by -e h carrier_rate along delta
    travel +=
        dt * (std::cos(delta) * (vx - omega * y) + std::sin(delta) * (vy + omega * x) - e * h * carrier_rate);
  }
  return travel;
}

TEST(TrueMotion, wheelTravelsAreThoseOfTheDefinition) {
  const auto swerving = [](double t) {
    return Command{1.0 + 0.3 * std::sin(0.7 * t), 0.1 + 0.4 * std::sin(0.5 * t), 0.0};
  };
  const Scenario scenario{"test", 20.0, 100.0, swerving, {}};
  for (AxleGeometry geometry : {AxleGeometry::kAckermann, AxleGeometry::kPivot}) {
    const Vehicle vehicle = oddCar(geometry);
    const TrueMotion motion = driven(vehicle, scenario, 0.005);
    for (Wheel wheel : kAllWheels)
      EXPECT_NEAR(motion.travel(wheel), travelByDefinition(wheel, vehicle, scenario), 2e-7) << name(wheel);
  }
}

// --- references ----------------------------------------------------------------------------------------

// docs/model.md, section 8.4: true gains (1.02, 0.99, 1.03), so the track is 1.236 m. The rear axle's middle
// goes Int V dt = 1.35 (15 - 0.5 - 0.4) m.
TEST(TrueMotion, fig4HasTheReferenceWheelTravels) {
  const Vehicle vehicle = cycab();
  TrueMotion motion(TrueBody(vehicle, withScenarioGains(vehicle), Drivetrain::kSteered),
                    makeScenario("fig4", vehicle), {}, 1, 0.001, Pose{});
  double distance = 0.0;
  for (int i = 1; i <= 15000; ++i) {
    const Pose before = motion.pose();
    motion.advanceTo(0.001 * i);
    // middle of the rear axle, 0.6 m behind base_link
    const double x = motion.pose().x - before.x - 0.6 * (std::cos(motion.pose().yaw) - std::cos(before.yaw));
    const double y = motion.pose().y - before.y - 0.6 * (std::sin(motion.pose().yaw) - std::sin(before.yaw));
    distance += std::hypot(x, y);
  }
  EXPECT_NEAR(motion.travel(Wheel::kRearRight), 20.053184258, kPrinted);
  EXPECT_NEAR(motion.travel(Wheel::kRearLeft), 18.033382088, kPrinted);
  EXPECT_NEAR(distance, 19.035, 1e-7);
}

TEST(TrueMotion, halvingTheSubstepChangesNothing) {
  for (const std::string& name : scenarioNames())
    for (AxleGeometry geometry : {AxleGeometry::kAckermann, AxleGeometry::kPivot}) {
      const Vehicle vehicle = oddCar(geometry);
      const Scenario scenario = makeScenario(name, vehicle);
      const TrueMotion once = driven(vehicle, scenario, 0.001);
      const TrueMotion twice = driven(vehicle, scenario, 0.0005);
      const double tolerance = 1e-9 * once.travel(Wheel::kRearRight);
      EXPECT_NEAR(once.pose().x, twice.pose().x, tolerance) << name;
      EXPECT_NEAR(once.pose().y, twice.pose().y, tolerance) << name;
      EXPECT_NEAR(once.pose().yaw, twice.pose().yaw, 1e-9) << name;
      for (Wheel wheel : kAllWheels) EXPECT_NEAR(once.travel(wheel), twice.travel(wheel), tolerance) << name;
    }
}

// --- the clock -----------------------------------------------------------------------------------------

TEST(TrueMotion, doesNotDependOnWhenItIsAsked) {
  const Vehicle vehicle = cycab();
  const TrueMotion::Noise noise{0.002, 0.005, 0.1};
  TrueMotion seldom = motionOf(vehicle, makeScenario("fig4", vehicle), 0.005, Drivetrain::kSteered, noise, 3);
  TrueMotion often = motionOf(vehicle, makeScenario("fig4", vehicle), 0.005, Drivetrain::kSteered, noise, 3);
  seldom.advanceTo(15.0);
  for (int i = 1; i <= 4321; ++i) often.advanceTo(15.0 * i / 4321.0);
  EXPECT_NEAR(seldom.pose().x, often.pose().x, 1e-7);
  EXPECT_NEAR(seldom.pose().y, often.pose().y, 1e-7);
  EXPECT_NEAR(seldom.pose().yaw, often.pose().yaw, 1e-7);
}

TEST(TrueMotion, cannotGoBack) {
  TrueMotion motion = motionOf(cycab(), makeScenario("fig4", cycab()));
  motion.advanceTo(1.0);
  motion.advanceTo(1.0);
  EXPECT_THROW(motion.advanceTo(0.999), std::invalid_argument);
  EXPECT_THROW(motion.advanceTo(std::nan("")), std::invalid_argument);
}

TEST(TrueMotion, aSpinningWheelRollsFurther) {
  const Vehicle vehicle = cycab();
  const TrueMotion clean = driven(vehicle, makeScenario("slalom_eight", vehicle));
  TrueMotion spinning = motionOf(vehicle, makeScenario("wheel_spin", vehicle));
  spinning.advanceTo(10.5);
  const double half_way = spinning.travel(Wheel::kRearRight);
  TrueMotion reference = motionOf(vehicle, makeScenario("slalom_eight", vehicle));
  reference.advanceTo(10.5);
  EXPECT_NEAR(half_way - reference.travel(Wheel::kRearRight), 0.15, 1e-12);
  spinning.advanceTo(60.0);
  EXPECT_NEAR(spinning.travel(Wheel::kRearRight) - clean.travel(Wheel::kRearRight), 0.9, 1e-12);
  EXPECT_NEAR(spinning.travel(Wheel::kRearLeft) - clean.travel(Wheel::kRearLeft), 0.0, 1e-12);
}

}  // namespace
}  // namespace bs_car_odometry::simulation
