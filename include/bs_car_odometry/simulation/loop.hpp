#pragma once

#include "bs_car_odometry/simulation/scenario.hpp"

#include <array>
#include <string>

namespace bs_car_odometry::simulation {

/// Four straight legs, each followed by a corner of 90 degrees to the left; the loop closes for every point
/// of the car, since four equal corners turn into each other.
struct Legs {
  std::array<double, 2> lengths;  ///< [m], first and third, second and fourth
  double speed;                   ///< [m/s]
};

/// Corners by steering at constant speed: phi goes smoothly to `corner_angle` within a metre (less for a car
/// that turns tightly), stays there and comes back; it stays as long as 90 degrees take.
/// @throws ScenarioError when the vehicle hardly turns at that angle
Scenario steeredLoop(const std::string& name, const Legs& legs, double corner_angle, const Vehicle& vehicle,
                     Drivetrain drivetrain);

/// Corners on the spot: the robot stops after each leg and turns at `yaw_rate` [rad/s], with 0.5 s to speed
/// up and down each.
Scenario loopOnTheSpot(const std::string& name, const Legs& legs, double yaw_rate);

}  // namespace bs_car_odometry::simulation
