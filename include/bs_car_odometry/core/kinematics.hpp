#pragma once

#include "bs_car_odometry/core/vehicle.hpp"

#include <Eigen/Core>

namespace bs_car_odometry {

/// Steering angles of both axles [rad], left positive.
struct SteeringAngles {
  double front{0.0};
  double rear{0.0};
  double operator[](Axle axle) const { return axle == Axle::kFront ? front : rear; }
};

/// Shape of the path that two steering angles ask for, whatever the speed (docs/model.md, K2).
struct PathShape {
  double curvature{0.0};  ///< kappa = omega/vx [1/m]
  double sideslip{0.0};   ///< beta = vy/vx at base_link
};

/// (K2) kappa = (tan phi_f - tan phi_r)/L,  beta = (a_f tan phi_r - a_r tan phi_f)/L; |phi| < pi/2.
PathShape pathShape(const Vehicle& vehicle, const SteeringAngles& steering);

/// Kingpin of a wheel in base_link [m]: on the axle, track/2 less the hub offset from the middle.
Eigen::Vector2d kingpin(const Vehicle& vehicle, Wheel wheel);

/// Rolling direction of a wheel in base_link [rad], left positive: (K3) at the kingpin with Ackermann axles,
/// the angle of the axle with pivot axles.
double wheelDirection(const Vehicle& vehicle, Wheel wheel, const SteeringAngles& steering);

/// Twist (vx, vy, omega) at base_link [m/s, m/s, rad/s] of a car whose axle middles do not slip sideways
/// (K2).
Eigen::Vector3d bodyTwist(const Vehicle& vehicle, double vx, const SteeringAngles& steering);

/// (K3) with the hub offset (H): speeds at which the wheels roll [m/s], forward positive, when the body moves
/// with `twist` (vx, vy, omega) at base_link and the wheels' directions turn at `direction_rates` [rad/s].
PerWheel<double> wheelSpeeds(const Vehicle& vehicle, const Eigen::Vector3d& twist,
                             const SteeringAngles& steering, const PerWheel<double>& direction_rates = {});

/// Angle of the axle [rad] that a wheel's own angle `direction` asks for, the other axle being at `other`:
/// the inverse of wheelDirection.
double axleAngle(const Vehicle& vehicle, Wheel wheel, double direction, double other);

}  // namespace bs_car_odometry
