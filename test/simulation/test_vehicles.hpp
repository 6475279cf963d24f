#pragma once

#include "bs_car_odometry/core/vehicle.hpp"
#include "bs_car_odometry/simulation/scenario.hpp"

#include <functional>
#include <utility>

namespace bs_car_odometry::simulation {

/// P1's Cycab: phi_rear = -phi_front, base_link midway.
inline Vehicle cycab() {
  Vehicle vehicle;
  vehicle.wheelbase = 1.2;
  vehicle.track = {1.2, 1.2};
  vehicle.base_link_x = 0.6;
  for (Wheel wheel : kAllWheels) vehicle.metres_per_tick[wheel] = 1e-4;
  return vehicle;
}

/// Nothing symmetrical: tracks, hub offsets, a cubic law, base_link anywhere.
inline Vehicle oddCar(AxleGeometry geometry) {
  Vehicle vehicle = cycab();
  vehicle.wheelbase = 1.7;
  vehicle.track = {1.3, 1.1};
  vehicle.base_link_x = 0.4;
  vehicle.hub_offset = {0.08, -0.03};
  vehicle.axle_geometry = geometry;
  vehicle.rear_steering.coefficients = {0.02, -0.7, 0.0, 0.1};
  return vehicle;
}

/// Two driven rear wheels at x = 0.
inline Vehicle robot() {
  Vehicle vehicle = cycab();
  vehicle.base_link_x = 0.0;
  vehicle.track = {0.4, 0.4};
  vehicle.rear_steering.coefficients = {0.0};
  vehicle.metres_per_tick[Wheel::kFrontLeft] = 0.0;
  vehicle.metres_per_tick[Wheel::kFrontRight] = 0.0;
  return vehicle;
}

inline Scenario drive(double duration, std::function<Command(double)> pattern) {
  return {"test", duration, duration, std::move(pattern), {}};
}

inline Scenario constantDrive(double duration, double speed, double front_angle, double yaw_rate = 0.0) {
  return drive(duration, [=](double) { return Command{speed, front_angle, yaw_rate}; });
}

}  // namespace bs_car_odometry::simulation
