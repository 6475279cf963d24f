#pragma once

#include "bs_car_odometry/core/vehicle.hpp"

namespace bs_car_odometry::drives {

/// A micrometre a tick: rounding does not hide what the model does.
constexpr double kFineTick = 1e-6;

/// The papers' Cycab, phi_rear = -phi_front, base_link on the rear axle.
inline Vehicle cycab(AxleGeometry geometry = AxleGeometry::kAckermann, double metres_per_tick = kFineTick) {
  Vehicle vehicle;
  vehicle.wheelbase = 1.2;
  vehicle.track = {1.2, 1.2};
  vehicle.axle_geometry = geometry;
  for (const Wheel wheel : kAllWheels) vehicle.metres_per_tick[wheel] = metres_per_tick;
  return vehicle;
}

/// Kingpins 0.1 m inside the contact points.
inline Vehicle cycabWithHubs(AxleGeometry geometry) {
  Vehicle vehicle = cycab(geometry);
  vehicle.hub_offset = {0.1, 0.1};
  return vehicle;
}

/// Tracks that differ, base_link midway between the axles.
inline Vehicle unevenCycab(AxleGeometry geometry) {
  Vehicle vehicle = cycab(geometry);
  vehicle.track = {1.3, 1.1};
  vehicle.base_link_x = 0.6;
  return vehicle;
}

/// A rear axle with an angle sensor of its own; the simulated car steers it by the law, the odometry reads
/// it.
inline Vehicle cycabWithRearSensor(AxleGeometry geometry) {
  Vehicle vehicle = cycab(geometry);
  vehicle.rear_steering.source = RearSteering::Source::kMeasured;
  return vehicle;
}

/// Only the front wheels steer.
inline Vehicle ordinaryCar(AxleGeometry geometry) {
  Vehicle vehicle = cycab(geometry);
  vehicle.wheelbase = 2.6;
  vehicle.track = {1.5, 1.5};
  vehicle.rear_steering.coefficients = {0.0};
  return vehicle;
}

/// Two driven rear wheels, no steering.
inline Vehicle differentialRobot() {
  Vehicle vehicle = cycab();
  vehicle.track = {0.4, 0.4};
  vehicle.rear_steering.coefficients = {0.0};
  vehicle.metres_per_tick[Wheel::kFrontLeft] = 0.0;
  vehicle.metres_per_tick[Wheel::kFrontRight] = 0.0;
  return vehicle;
}

}  // namespace bs_car_odometry::drives
