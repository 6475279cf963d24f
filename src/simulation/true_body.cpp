#include "bs_car_odometry/simulation/true_body.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::simulation {

namespace {

Direction directionOf(double angle) { return {std::cos(angle), std::sin(angle)}; }

double side(Wheel wheel) { return isLeft(wheel) ? 1.0 : -1.0; }

}  // namespace

TrueBody::TrueBody(const Vehicle& vehicle, const TrueParameters& truth, Drivetrain drivetrain)
    : rear_steering_(vehicle.rear_steering),
      axle_geometry_(vehicle.axle_geometry),
      drivetrain_(drivetrain),
      wheelbase_(vehicle.wheelbase),
      axle_x_{vehicle.wheelbase - vehicle.base_link_x, -vehicle.base_link_x} {
  for (Axle axle : kAllAxles) half_track_[axle] = 0.5 * truth.gains[axle].k_b * vehicle.track[axle];
  for (Wheel wheel : kAllWheels) {
    const Axle axle = axleOf(wheel);
    kingpin_x_[wheel] = axle_x_[axle];
    kingpin_y_[wheel] = side(wheel) * (half_track_[axle] - vehicle.hub_offset[axle]);
    hub_arm_[wheel] = -side(wheel) * vehicle.hub_offset[axle];
  }
}

Instant TrueBody::instant(const Command& command, double law_error) const {
  Instant instant;
  instant.speed = command.speed;
  if (drivetrain_ == Drivetrain::kDifferential) {
    instant.yaw_rate = command.speed * std::tan(command.front_angle) / wheelbase_ + command.yaw_rate;
    instant.axle.rear = directionOf(law_error);
    for (Wheel wheel : kAllWheels) instant.wheel[wheel] = instant.axle[axleOf(wheel)];
    return instant;
  }
  instant.axle.front = directionOf(command.front_angle);
  instant.axle.rear = directionOf(rear_steering_.angle(command.front_angle) + law_error);
  instant.wheel = wheelDirections(instant);
  return instant;
}

Twist TrueBody::twist(const Instant& instant, const PerAxle<double>& slip) const {
  const Direction& front = instant.axle.front;
  const Direction& rear = instant.axle.rear;
  const double vx = instant.speed * rear.cos - slip.rear * rear.sin;
  const double v_Ry = instant.speed * rear.sin + slip.rear * rear.cos;
  double yaw_rate = instant.yaw_rate;
  if (drivetrain_ == Drivetrain::kSteered) {
    const double v_Fy = (slip.front + front.sin * vx) / front.cos;
    yaw_rate = (v_Fy - v_Ry) / wheelbase_;
  }
  return {vx, v_Ry - axle_x_.rear * yaw_rate, yaw_rate};
}

// Ackermann (K3): the kingpin's own direction when the car rolls ideally, whether or not it moves at present;
// of its two senses that which is nearer to the axle's (they differ only with the turning centre between the
// wheels).
PerWheel<Direction> TrueBody::wheelDirections(const Instant& instant) const {
  PerWheel<Direction> directions;
  if (axle_geometry_ == AxleGeometry::kPivot) {
    for (Wheel wheel : kAllWheels) directions[wheel] = instant.axle[axleOf(wheel)];
    return directions;
  }
  Instant ideal = instant;
  ideal.speed = 1.0;
  const Twist t = twist(ideal);
  for (Wheel wheel : kAllWheels) {
    const Direction& axle = instant.axle[axleOf(wheel)];
    const double vx = t.vx - t.yaw_rate * kingpin_y_[wheel];
    const double vy = t.vy + t.yaw_rate * kingpin_x_[wheel];
    const double squared = vx * vx + vy * vy;
    const double scale = std::copysign(1.0 / std::sqrt(squared), axle.cos * vx + axle.sin * vy);
    directions[wheel] = squared > 1e-24 ? Direction{vx * scale, vy * scale} : axle;
  }
  return directions;
}

double TrueBody::rollingSpeed(Wheel wheel, const Instant& instant, const Twist& twist) const {
  const Direction& direction = instant.wheel[wheel];
  return direction.cos * (twist.vx - twist.yaw_rate * kingpin_y_[wheel]) +
         direction.sin * (twist.vy + twist.yaw_rate * kingpin_x_[wheel]);
}

double TrueBody::axleTravelRate(Axle axle, const Instant& instant, const Twist& twist) const {
  const Direction& direction = instant.axle[axle];
  const double along = direction.cos * twist.vx + direction.sin * (twist.vy + axle_x_[axle] * twist.yaw_rate);
  return std::max(std::abs(along), std::abs(twist.yaw_rate * direction.cos) * half_track_[axle]);
}

}  // namespace bs_car_odometry::simulation
