#include "bs_car_odometry/simulation/true_motion.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace bs_car_odometry::simulation {

namespace {

constexpr std::uint64_t kSlipStream = 0;
constexpr std::uint64_t kLawStream = 1;
constexpr double kSameTime = 1e-11;  // s: rounding of times up to a day

Direction headingOf(double yaw) { return {std::cos(yaw), std::sin(yaw)}; }

/// Velocity of base_link in odom, as (x, y) of a direction-like pair.
struct Velocity {
  double x;
  double y;
};
Velocity inOdom(const Twist& twist, const Direction& heading) {
  return {heading.cos * twist.vx - heading.sin * twist.vy, heading.sin * twist.vx + heading.cos * twist.vy};
}

/// Simpson's rule for the integral over a step of length dt.
double simpson(double dt, double begin, double middle, double end) {
  return dt / 6.0 * (begin + 4.0 * middle + end);
}

/// Integral over the first half of the step, from the same three values: exact for parabolas.
double firstHalf(double dt, double begin, double middle, double end) {
  return dt / 24.0 * (5.0 * begin + 8.0 * middle - end);
}

}  // namespace

TrueMotion::TrueMotion(const TrueBody& body, Scenario scenario, const Noise& noise, std::uint64_t seed,
                       double substep, const Pose& initial_pose)
    : body_(body),
      scenario_(std::move(scenario)),
      noise_(noise),
      substep_(substep),
      slip_random_(seed, kSlipStream),
      law_error_(noise.rear_law, noise.correlation_length, Random(seed, kLawStream)),
      pose_(initial_pose),
      heading_(headingOf(initial_pose.yaw)) {
  if (!(substep > 0.0)) throw std::invalid_argument("substep must be positive");
  startSubstep();
  for (Wheel wheel : kAllWheels) carrier_start_[wheel] = carrierAngle(wheel);
}

void TrueMotion::advanceTo(double time) {
  if (!(time >= time_ - kSameTime)) throw std::invalid_argument("the simulated car cannot go back in time");
  for (;;) {
    const double substep_end = static_cast<double>(substeps_done_ + 1) * substep_;
    if (time < substep_end - kSameTime) break;
    integrateTo(substep_end);
    ++substeps_done_;
    startSubstep();
  }
  if (time > time_ + kSameTime) integrateTo(time);
}

void TrueMotion::startSubstep() {
  const double old_law_error = law_error_.value();
  law_error_.advance(rear_travel_);
  rear_travel_ = 0.0;
  if (law_error_.value() != old_law_error || substeps_done_ == 0)
    now_ = body_.instant(scenario_.commandAt(time_), law_error_.value());
  if (noise_.lateral.scale() <= 0.0) return;
  // A constant velocity n over the substep dt that displaces by a draw of lateral times sqrt(travel):
  // n dt = lateral sqrt(rate dt).
  const Twist twist = body_.twist(now_);
  for (Axle axle : kAllAxles)
    slip_[axle] = noise_.lateral.scale() * std::sqrt(body_.axleTravelRate(axle, now_, twist) / substep_) *
                  slip_random_.drawUnscaled(noise_.lateral);
}

void TrueMotion::integrateTo(double time) {
  const double dt = time - time_;
  const double law_error = law_error_.value();
  const Instant begin = now_;
  const Instant middle = body_.instant(scenario_.commandAt(time_ + 0.5 * dt), law_error);
  now_ = body_.instant(scenario_.commandAt(time), law_error);
  const Twist t0 = body_.twist(begin, slip_);
  const Twist t1 = body_.twist(middle, slip_);
  const Twist t2 = body_.twist(now_, slip_);

  const Velocity v0 = inOdom(t0, heading_);
  const Velocity v1 = inOdom(t1, headingOf(pose_.yaw + firstHalf(dt, t0.yaw_rate, t1.yaw_rate, t2.yaw_rate)));
  pose_.yaw += simpson(dt, t0.yaw_rate, t1.yaw_rate, t2.yaw_rate);
  heading_ = headingOf(pose_.yaw);
  const Velocity v2 = inOdom(t2, heading_);
  pose_.x += simpson(dt, v0.x, v1.x, v2.x);
  pose_.y += simpson(dt, v0.y, v1.y, v2.y);

  for (Wheel wheel : kAllWheels)
    kingpin_travel_[wheel] +=
        simpson(dt, body_.rollingSpeed(wheel, begin, t0), body_.rollingSpeed(wheel, middle, t1),
                body_.rollingSpeed(wheel, now_, t2));
  rear_travel_ += dt * body_.axleTravelRate(Axle::kRear, middle, t1);
  time_ = time;
}

double TrueMotion::angle(Axle axle) const { return std::atan2(now_.axle[axle].sin, now_.axle[axle].cos); }

// The carrier turns with omega + d(delta)/dt, an exact derivative, so what it rolls follows from its
// direction.
double TrueMotion::carrierAngle(Wheel wheel) const {
  const Direction& direction = now_.wheel[wheel];
  return pose_.yaw + std::atan2(direction.sin, direction.cos);
}

double TrueMotion::travel(Wheel wheel) const {
  double travel = kingpin_travel_[wheel];
  if (body_.hubArm(wheel) != 0.0)
    travel += body_.hubArm(wheel) * (carrierAngle(wheel) - carrier_start_[wheel]);
  for (const WheelSpin& spin : scenario_.wheel_spins)
    if (spin.wheel == wheel) travel += spin.speed * std::max(0.0, std::min(time_, spin.until) - spin.from);
  return travel;
}

}  // namespace bs_car_odometry::simulation
