#include "bs_car_odometry/simulation/loop.hpp"

#include "bs_car_odometry/simulation/smooth_step.hpp"
#include "bs_car_odometry/simulation/true_body.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::simulation {

namespace {

constexpr double kQuarterTurn = 1.570796326794896619231;
constexpr double kLongestRamp = 1.0;  // m
constexpr double kPause = 0.5;        // s, to speed up or down

/// Yaw rate at the rear axle's speed and front angle [rad/s].
double yawRate(const TrueBody& body, double speed, double front_angle) {
  return body.twist(body.instant({speed, front_angle, 0.0}, 0.0)).yaw_rate;
}

/// Heading turned while the angle goes smoothly from 0 to `angle` in `time`: Simpson's rule.
double headingOfRamp(const TrueBody& body, double speed, double angle, double time) {
  constexpr int kIntervals = 1000;
  double sum = 0.0;
  for (int i = 0; i <= kIntervals; ++i) {
    const bool at_end = i == 0 || i == kIntervals;
    const double weight = at_end ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    sum += weight * yawRate(body, speed, angle * smoothStep(i, 0.0, kIntervals));
  }
  return sum * time / (3.0 * kIntervals);
}

/// Where the loop is: in a leg, or in the corner after it.
struct Place {
  bool in_corner;
  double time;    ///< since the leg or the corner began [s]
  double length;  ///< of the leg or the corner [s]
};

Place placeAt(double t, double first_leg, double second_leg, double corner) {
  t = std::fmod(t, first_leg + second_leg + 2.0 * corner);
  double leg = first_leg;
  if (t >= first_leg + corner) {
    t -= first_leg + corner;
    leg = second_leg;
  }
  return t < leg ? Place{false, t, leg} : Place{true, t - leg, corner};
}

}  // namespace

Scenario steeredLoop(const std::string& name, const Legs& legs, double corner_angle, const Vehicle& vehicle,
                     Drivetrain drivetrain) {
  const TrueBody body(vehicle, {}, drivetrain);
  const double v = legs.speed;
  const double curvature = yawRate(body, 1.0, corner_angle);
  if (std::abs(curvature) < 1e-3)
    throw ScenarioError("scenario " + name + ": this vehicle hardly turns at a front angle of " +
                        std::to_string(corner_angle) + " rad");
  const double phi = std::copysign(corner_angle, curvature);
  const double ramp = std::min(kLongestRamp, 0.5 * kQuarterTurn / std::abs(curvature)) / v;
  const double hold = (kQuarterTurn - 2.0 * headingOfRamp(body, v, phi, ramp)) / yawRate(body, v, phi);
  const double corner = hold + 2.0 * ramp;
  const double first = legs.lengths[0] / v;
  const double second = legs.lengths[1] / v;
  const auto pattern = [=](double t) {
    const Place place = placeAt(t, first, second, corner);
    return Command{v, place.in_corner ? phi * smoothPulse(place.time, ramp, corner) : 0.0, 0.0};
  };
  const double period = 2.0 * (first + second + 2.0 * corner);
  return {name, period, period, pattern, {}};
}

Scenario loopOnTheSpot(const std::string& name, const Legs& legs, double yaw_rate) {
  const double v = legs.speed;
  const double first = legs.lengths[0] / v + kPause;
  const double second = legs.lengths[1] / v + kPause;
  const double corner = kQuarterTurn / yaw_rate + kPause;
  const auto pattern = [=](double t) {
    const Place place = placeAt(t, first, second, corner);
    const double pulse = smoothPulse(place.time, kPause, place.length);
    return place.in_corner ? Command{0.0, 0.0, yaw_rate * pulse} : Command{v * pulse, 0.0, 0.0};
  };
  const double period = 2.0 * (first + second + 2.0 * corner);
  return {name, period, period, pattern, {}};
}

}  // namespace bs_car_odometry::simulation
