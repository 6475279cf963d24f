#include "bs_car_odometry/simulation/scenario.hpp"

#include "bs_car_odometry/simulation/loop.hpp"
#include "bs_car_odometry/simulation/smooth_step.hpp"

#include <array>
#include <cmath>

namespace bs_car_odometry::simulation {

namespace {

constexpr double kTwoPi = 6.283185307179586476925;

struct Request {
  const Vehicle& vehicle;
  Drivetrain drivetrain;
  double speed_factor;
};

/// P1's experiment (docs/model.md, section 8.4):
///   V(t)   = 1.35 (s(t;0,1) - s(t;14.2,15))
///   phi(t) = 0.035 (s(t;0.5,1.5) - s(t;4.6,5.2)) + 0.27 (s(t;5.2,6) - s(t;7.7,8.5))
///            - 0.05 (s(t;9,10) - s(t;11,12)) + 0.03 (s(t;12.5,13) - s(t;14,14.5))
Scenario fig4(const Request& request) {
  const double speed = 1.35 * request.speed_factor;
  const auto pattern = [speed](double t) {
    Command command;
    command.speed = speed * (smoothStep(t, 0.0, 1.0) - smoothStep(t, 14.2, 15.0));
    command.front_angle = 0.035 * (smoothStep(t, 0.5, 1.5) - smoothStep(t, 4.6, 5.2)) +
                          0.27 * (smoothStep(t, 5.2, 6.0) - smoothStep(t, 7.7, 8.5)) -
                          0.05 * (smoothStep(t, 9.0, 10.0) - smoothStep(t, 11.0, 12.0)) +
                          0.03 * (smoothStep(t, 12.5, 13.0) - smoothStep(t, 14.0, 14.5));
    return command;
  };
  return {"fig4", 15.0, 15.0, pattern, {}};
}

/// V = 1, phi(t) = 0.4 sin(2 pi t / 20): eights, 60 s of them.
Scenario slalomEight(const Request& request) {
  const double speed = request.speed_factor;
  const auto pattern = [speed](double t) { return Command{speed, 0.4 * std::sin(kTwoPi * t / 20.0), 0.0}; };
  return {"slalom_eight", 60.0, 20.0, pattern, {}};
}

/// V = 2, phi = 0.3 for 30 s, already turning at the start.
Scenario circle(const Request& request) {
  const double speed = 2.0 * request.speed_factor;
  return {"circle", 30.0, 30.0, [speed](double) { return Command{speed, 0.3, 0.0}; }, {}};
}

/// 20 m ahead at v = 1, T = 20/v + 1: V(t) = v (s(t;0,1) - s(t;T-1,T)).
Scenario straight(const Request& request) {
  const double speed = request.speed_factor;
  const double duration = 20.0 / speed + 1.0;
  const auto pattern = [speed, duration](double t) {
    return Command{speed * smoothPulse(t, 1.0, duration), 0.0, 0.0};
  };
  return {"straight", duration, duration, pattern, {}};
}

/// P2's experiment: legs of 10 and 4.5 m at 0.2 m/s, left corners. A differential robot turns on the spot, 90
/// degrees in 3.15 s (63 steps at 20 Hz) and 0.5 s of speeding up and down; a steered car at phi = 0.4.
Scenario rectangle(const Request& request) {
  const double speed = 0.2 * request.speed_factor;
  if (request.drivetrain == Drivetrain::kDifferential)
    return loopOnTheSpot("rectangle", {{10.0, 4.5}, speed}, 0.25 * kTwoPi / 3.15 * request.speed_factor);
  return steeredLoop("rectangle", {{10.0, 4.5}, speed}, 0.4, request.vehicle, request.drivetrain);
}

/// Four times 20 m straight and 90 degrees left at phi = 0.25, at 1 m/s.
Scenario squareLoop(const Request& request) {
  return steeredLoop("square_loop", {{20.0, 20.0}, request.speed_factor}, 0.25, request.vehicle,
                     request.drivetrain);
}

/// slalom_eight whose right rear wheel spins for a second, 0.3 m/s, after 10, 25 and 40 s.
Scenario wheelSpin(const Request& request) {
  Scenario scenario = slalomEight(request);
  scenario.name = "wheel_spin";
  for (double from : {10.0, 25.0, 40.0})
    scenario.wheel_spins.push_back({Wheel::kRearRight, from, from + 1.0, 0.3});
  return scenario;
}

struct Entry {
  const char* name;
  const char* description;
  Scenario (*make)(const Request&);
};

constexpr std::array<Entry, 7> kEntries{{
    {"fig4", "15 s, 19 m: the calibration drive of the paper's figure 4, with a bend and gentle swerves",
     fig4},
    {"slalom_eight", "60 s, 60 m: eights, the front angle swings by +/-0.4 rad in 20 s", slalomEight},
    {"circle", "30 s, 60 m: a circle at 0.3 rad and 2 m/s", circle},
    {"straight", "21 s, 20 m: straight ahead, from rest to rest", straight},
    {"rectangle", "10 x 4.5 m at 0.2 m/s, left corners (a differential robot turns them on the spot)",
     rectangle},
    {"square_loop", "99 m: four times 20 m and a left corner at 0.25 rad, 1 m/s", squareLoop},
    {"wheel_spin", "slalom_eight with a right rear wheel that spins for a second, three times", wheelSpin},
}};

}  // namespace

Drivetrain drivetrainOf(const Vehicle& vehicle, AxleSelection axles) {
  const RearSteering& rear = vehicle.rear_steering;
  const bool rear_fixed =
      rear.source == RearSteering::Source::kPolynomial && rear.isConstant() && rear.angle(0.0) == 0.0;
  const bool front_wheels = vehicle.hasEncoder(Wheel::kFrontLeft) || vehicle.hasEncoder(Wheel::kFrontRight);
  return rear_fixed && !front_wheels && axles == AxleSelection::kRear ? Drivetrain::kDifferential
                                                                      : Drivetrain::kSteered;
}

Command Scenario::commandAt(double time) const {
  return pattern(time < period ? time : std::fmod(time, period));
}

Scenario makeScenario(const std::string& name, const Vehicle& vehicle, Drivetrain drivetrain,
                      double speed_factor) {
  if (!(speed_factor > 0.0)) throw ScenarioError("speed factor must be positive");
  for (const Entry& entry : kEntries)
    if (name == entry.name) return entry.make({vehicle, drivetrain, speed_factor});
  std::string message = "unknown scenario '" + name + "'; known are";
  for (const Entry& entry : kEntries) message += std::string(" ") + entry.name;
  throw ScenarioError(message);
}

std::vector<std::string> scenarioNames() {
  std::vector<std::string> names;
  names.reserve(kEntries.size());
  for (const Entry& entry : kEntries) names.emplace_back(entry.name);
  return names;
}

std::string scenarioDescriptions() {
  std::string text;
  for (const Entry& entry : kEntries) {
    std::string name = entry.name;
    name.resize(14, ' ');
    text += "  " + name + entry.description + "\n";
  }
  return text;
}

}  // namespace bs_car_odometry::simulation
