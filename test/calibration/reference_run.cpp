#include "reference_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace bs_car_odometry::calibration::reference {

namespace {

double rise(double t, double begin, double end) {
  const double u = std::min(std::max((t - begin) / (end - begin), 0.0), 1.0);
  return u * u * (3.0 - 2.0 * u);
}

/// Gauss-Legendre with four points on sixteen parts of the step.
double integral(const std::function<double(double)>& f, double begin, double end) {
  constexpr std::array<double, 2> kPlace{0.339981043584856265, 0.861136311594052575};
  constexpr std::array<double, 2> kWeight{0.652145154862546143, 0.347854845137453857};
  constexpr int kParts = 16;
  const double half = 0.5 * (end - begin) / kParts;
  double sum = 0.0;
  for (int part = 0; part < kParts; ++part) {
    const double middle = begin + (2 * part + 1) * half;
    for (std::size_t i = 0; i < kPlace.size(); ++i)
      sum += kWeight[i] * (f(middle - kPlace[i] * half) + f(middle + kPlace[i] * half));
  }
  return half * sum;
}

double yawRate(const Commands& commands, double t) {
  return 2.0 * commands.speed(t) * std::sin(commands.angle(t)) / kWheelbase;  // (K2), phi_r = -phi
}

/// Speed of a rear wheel that rolls along its own velocity.
/// @param side  -1 right, +1 left
double wheelSpeed(const Commands& commands, double side, double t) {
  const double speed = commands.speed(t);
  const double phi = commands.angle(t);
  const double along = speed * std::cos(phi) - side * 0.5 * kTrackGain * kTrack * yawRate(commands, t);
  return std::hypot(along, speed * std::sin(phi));
}

Eigen::Vector3d moved(const Eigen::Vector3d& pose, const Step& step) {
  const double dth = (step.right - step.left) / (kTrackGain * kTrack * std::cos(step.alpha));
  const double travel = 0.5 * (step.right + step.left);
  const double psi = pose.z() + step.alpha + 0.5 * dth;
  return {pose.x() + travel * std::cos(psi), pose.y() + travel * std::sin(psi), pose.z() + dth};
}

}  // namespace

Commands fifteenSeconds() {
  return {[](double t) { return 1.35 * (rise(t, 0.0, 1.0) - rise(t, 14.2, 15.0)); },
          [](double t) {
            return 0.035 * (rise(t, 0.5, 1.5) - rise(t, 4.6, 5.2)) +
                   0.27 * (rise(t, 5.2, 6.0) - rise(t, 7.7, 8.5)) -
                   0.05 * (rise(t, 9.0, 10.0) - rise(t, 11.0, 12.0)) +
                   0.03 * (rise(t, 12.5, 13.0) - rise(t, 14.0, 14.5));
          }};
}

Commands slalomEight() {
  return {[](double) { return 1.0; }, [](double t) { return 0.4 * std::sin(2.0 * M_PI * t / 20.0); }};
}

std::vector<Step> drive(const Commands& commands, double duration) {
  const auto count = static_cast<int>(std::lround(duration / kPeriod));
  std::vector<Step> steps;
  Eigen::Vector3d pose = Eigen::Vector3d::Zero();
  double distance = 0.0;
  for (int i = 1; i <= count; ++i) {
    const double begin = (i - 1) * kPeriod;
    const double end = i * kPeriod;
    Step step;
    step.right = integral([&](double t) { return wheelSpeed(commands, -1.0, t); }, begin, end);
    step.left = integral([&](double t) { return wheelSpeed(commands, 1.0, t); }, begin, end);
    step.alpha = -0.5 * (commands.angle(begin) + commands.angle(end));
    distance += 0.5 * (step.right + step.left);
    step.distance = distance;
    step.before = pose;
    step.after = pose = moved(pose, step);
    step.laser = i % kLaserEvery == 0;
    steps.push_back(step);
  }
  for (std::size_t i = 0; i + 1 < steps.size(); ++i)
    steps[i].velocity = (steps[i + 1].after - steps[i].before) / (2.0 * kPeriod);
  return steps;
}

Linearised linearise(const Step& step) {
  const double dS = 0.5 * (step.right + step.left);
  const double dth = step.after.z() - step.before.z();
  const double k = 1.0 / (kTrackGain * kTrack * std::cos(step.alpha));
  const double psi = step.before.z() + step.alpha + 0.5 * dth;
  const double C = std::cos(psi);
  const double S = std::sin(psi);
  const double tangent = std::tan(step.alpha);
  const double g = 1.0 + 0.5 * dth * tangent;
  Linearised at;
  at.F << 1.0, 0.0, -dS * S, 0.0, 1.0, dS * C, 0.0, 0.0, 1.0;
  at.G << 0.5 * C - 0.5 * dS * k * S, 0.5 * C + 0.5 * dS * k * S, -dS * S * g,  //
      0.5 * S + 0.5 * dS * k * C, 0.5 * S - 0.5 * dS * k * C, dS * C * g,       //
      k, -k, dth * tangent;
  at.J.col(0) = at.G.col(0) * step.right / kRightGain;
  at.J.col(1) = at.G.col(1) * step.left / kLeftGain;
  at.J.col(2) = Eigen::Vector3d(0.5 * dS * S * dth, -0.5 * dS * C * dth, -dth) / kTrackGain;
  const double wheel = kWheel * kWheel;
  const double rounding = kRounding * kRounding;
  at.variance << wheel * std::abs(step.right) + rounding, wheel * std::abs(step.left) + rounding,
      kAngle * kAngle;
  return at;
}

Eigen::Matrix3d laserCovariance() { return Eigen::Vector3d(4e-4, 4e-4, 2.5e-5).asDiagonal(); }

}  // namespace bs_car_odometry::calibration::reference
