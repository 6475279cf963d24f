#include "bs_car_odometry/core/kinematics.hpp"

#include <cmath>

namespace bs_car_odometry {

PathShape pathShape(const Vehicle& vehicle, const SteeringAngles& steering) {
  const double tan_front = std::tan(steering.front);
  const double tan_rear = std::tan(steering.rear);
  const double a_f = vehicle.axleX(Axle::kFront);
  const double a_r = vehicle.axleX(Axle::kRear);
  return {(tan_front - tan_rear) / vehicle.wheelbase, (a_f * tan_rear - a_r * tan_front) / vehicle.wheelbase};
}

Eigen::Vector2d kingpin(const Vehicle& vehicle, Wheel wheel) {
  const Axle axle = axleOf(wheel);
  const double half = 0.5 * vehicle.calibratedTrack(axle) - vehicle.hub_offset[axle];
  return {vehicle.axleX(axle), isLeft(wheel) ? half : -half};
}

double wheelDirection(const Vehicle& vehicle, Wheel wheel, const SteeringAngles& steering) {
  if (vehicle.axle_geometry == AxleGeometry::kPivot) return steering[axleOf(wheel)];
  const PathShape path = pathShape(vehicle, steering);
  const Eigen::Vector2d pin = kingpin(vehicle, wheel);
  const double direction =
      std::atan2(path.sideslip + path.curvature * pin.x(), 1.0 - path.curvature * pin.y());
  // With the turning centre between the wheels the inner one rolls backwards: it does not turn round.
  const bool turned_round = std::cos(direction - steering[axleOf(wheel)]) < 0.0;
  return turned_round ? direction - std::copysign(M_PI, direction) : direction;
}

Eigen::Vector3d bodyTwist(const Vehicle& vehicle, double vx, const SteeringAngles& steering) {
  const PathShape path = pathShape(vehicle, steering);
  return {vx, path.sideslip * vx, path.curvature * vx};
}

PerWheel<double> wheelSpeeds(const Vehicle& vehicle, const Eigen::Vector3d& twist,
                             const SteeringAngles& steering, const PerWheel<double>& direction_rates) {
  PerWheel<double> speeds;
  for (const Wheel wheel : kAllWheels) {
    const Eigen::Vector2d pin = kingpin(vehicle, wheel);
    const double delta = wheelDirection(vehicle, wheel, steering);
    const double vx = twist.x() - twist.z() * pin.y();
    const double vy = twist.y() + twist.z() * pin.x();
    const double outward = (isLeft(wheel) ? 1.0 : -1.0) * vehicle.hub_offset[axleOf(wheel)];
    speeds[wheel] =
        std::cos(delta) * vx + std::sin(delta) * vy - outward * (twist.z() + direction_rates[wheel]);
  }
  return speeds;
}

double axleAngle(const Vehicle& vehicle, Wheel wheel, double direction, double other) {
  if (vehicle.axle_geometry == AxleGeometry::kPivot) return direction;
  // (K3) with the kingpin on its own axle, x = a_j: tan(delta) = tan(phi_j) / (1 - kappa y), and kappa is
  // linear in tan(phi_j): kappa = +/-(tan(phi_j) - tan(other))/L, plus on the front axle, minus on the rear
  // one.
  const double sign = axleOf(wheel) == Axle::kFront ? 1.0 : -1.0;
  const double y_over_L = kingpin(vehicle, wheel).y() / vehicle.wheelbase;
  const double t = std::tan(direction);
  return std::atan(t * (1.0 + sign * std::tan(other) * y_over_L) / (1.0 + sign * t * y_over_L));
}

}  // namespace bs_car_odometry
