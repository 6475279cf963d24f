#include "bs_car_odometry/core/axle_odometry.hpp"

#include <Eigen/LU>

#include <cmath>

namespace bs_car_odometry {

namespace {

enum Input { kRight, kLeft, kAlpha, kTrack };

/// Model (B) divides by its smaller root v. Below this fraction of the larger one a wheel all but stands
/// while the other turns, which is noise at standstill and never a car in motion.
constexpr double kSmallestRootRatio = 1e-3;

}  // namespace

AxleMotion pivotAxle(double right, double left, double alpha, double alpha_change, double track,
                     double hub_offset) {
  const double c = std::cos(alpha);
  const double between_kingpins = track - 2.0 * hub_offset;
  const double k = 1.0 / (between_kingpins * c + 2.0 * hub_offset);
  AxleMotion motion;
  motion.travel = 0.5 * (right + left);
  motion.heading = k * (right - left - 2.0 * hub_offset * alpha_change);
  motion.J << 0.5, 0.5, 0.0, 0.0,  //
      k, -k, k * motion.heading * between_kingpins * std::sin(alpha), -k * motion.heading * c;
  return motion;
}

AxleMotion unshortenedAxle(double right, double left, double track) {
  AxleMotion motion;
  motion.travel = 0.5 * (right + left);
  motion.heading = (right - left) / track;
  motion.J << 0.5, 0.5, 0.0, 0.0,  //
      1.0 / track, -1.0 / track, 0.0, -motion.heading / track;
  return motion;
}

AxleMotion ackermannAxle(double right, double left, double alpha, double track) {
  const double c = std::cos(alpha);
  const double P = 0.5 * (right * right + left * left);
  const double Q = 0.5 * (right * right - left * left) / c;
  const double u = std::sqrt(std::max(P + Q, 0.0));
  const double v = std::sqrt(std::max(P - Q, 0.0));
  if (right * left <= 0.0 || std::min(u, v) < kSmallestRootRatio * std::max(u, v))
    return pivotAxle(right, left, alpha, 0.0, track, 0.0);

  // From u^2 = P + Q and v^2 = P - Q.
  const double t = std::tan(alpha);
  const Eigen::RowVector3d du(0.5 * right * (1.0 + 1.0 / c) / u, 0.5 * left * (1.0 - 1.0 / c) / u,
                              0.5 * Q * t / u);
  const Eigen::RowVector3d dv(0.5 * right * (1.0 - 1.0 / c) / v, 0.5 * left * (1.0 + 1.0 / c) / v,
                              -0.5 * Q * t / v);
  const double sigma = right > 0.0 ? 1.0 : -1.0;
  AxleMotion motion;
  motion.travel = 0.5 * sigma * (u + v);
  motion.heading = sigma * (u - v) / track;
  motion.J.row(0) << 0.5 * sigma * (du + dv), 0.0;
  motion.J.row(1) << sigma / track * (du - dv), -motion.heading / track;
  return motion;
}

AxleMotion directedAxle(double right, double left, double alpha, double delta_right, double delta_left,
                        double track) {
  Eigen::Matrix2d A;
  A << std::cos(delta_right - alpha), 0.5 * track * std::cos(delta_right),  //
      std::cos(delta_left - alpha), -0.5 * track * std::cos(delta_left);
  const Eigen::Matrix2d inverse = A.inverse();
  const Eigen::Vector2d solution = inverse * Eigen::Vector2d(right, left);
  AxleMotion motion;
  motion.travel = solution(0);
  motion.heading = solution(1);
  motion.J.leftCols<2>() = inverse;
  return motion;
}

AxleOdometry::AxleOdometry(const Vehicle& vehicle, const NoiseModel& noise, const OdometryOptions& options,
                           Axle axle)
    : vehicle_(vehicle), noise_(noise), options_(options), axle_(axle) {}

AxleMotion AxleOdometry::axleMotion(const StepReadings& readings) const {
  const double right = readings.travel[rightWheel(axle_)];
  const double left = readings.travel[leftWheel(axle_)];
  const double track = vehicle_.calibratedTrack(axle_);
  if (!options_.shortened_track) return unshortenedAxle(right, left, track);
  if (options_.motion == Motion::kPaper)
    return pivotAxle(right, left, readings.end[axle_], 0.0, track, 0.0);  // as printed: no hub offset
  const double alpha = readings.mean()[axle_];
  const double hub_offset = vehicle_.hub_offset[axle_];
  if (vehicle_.axle_geometry == AxleGeometry::kPivot)
    return pivotAxle(right, left, alpha, readings.end[axle_] - readings.begin[axle_], track, hub_offset);
  return hub_offset == 0.0 ? ackermannAxle(right, left, alpha, track) : ackermannWithHub(readings);
}

/// (H) with model (B): the kingpins' travels S* = S + e h (dtheta + d_delta) depend on the unknown dtheta.
/// From the exact inversion of the pivot axle two Newton steps reach rounding error, since h is small against
/// B.
AxleMotion AxleOdometry::ackermannWithHub(const StepReadings& readings) const {
  const double h = vehicle_.hub_offset[axle_];
  const double track = vehicle_.calibratedTrack(axle_);
  const double alpha = readings.mean()[axle_];
  const double alpha_change = readings.end[axle_] - readings.begin[axle_];
  const auto turn = [&](Wheel wheel) {
    return wheelDirection(vehicle_, wheel, readings.end) - wheelDirection(vehicle_, wheel, readings.begin);
  };
  const double right = readings.travel[rightWheel(axle_)] - h * turn(rightWheel(axle_));
  const double left = readings.travel[leftWheel(axle_)] + h * turn(leftWheel(axle_));

  double heading = pivotAxle(right, left, alpha, alpha_change, track, h).heading;
  AxleMotion motion;
  double total_slope = 1.0;
  for (int round = 0; round < 3; ++round) {
    motion = ackermannAxle(right - h * heading, left + h * heading, alpha, track - 2.0 * h);
    total_slope = 1.0 + h * (motion.J(1, kRight) - motion.J(1, kLeft));
    heading -= (heading - motion.heading) / total_slope;
  }
  motion.heading = heading;
  // Implicit derivatives: S* itself moves with dtheta.
  motion.J.row(1) /= total_slope;
  motion.J.row(0) += h * (motion.J(0, kLeft) - motion.J(0, kRight)) * motion.J.row(1).eval();
  return motion;
}

/// @return dt/d(S_r, S_l, alpha, B)
Eigen::Matrix<double, 3, 4> AxleOdometry::setMotion(const StepReadings& readings, BodyMotion& motion) const {
  const bool paper = options_.motion == Motion::kPaper;
  const AxleMotion axle = axleMotion(readings);
  const double alpha = paper ? readings.end[axle_] : readings.mean()[axle_];
  const double alpha_change = paper ? 0.0 : readings.end[axle_] - readings.begin[axle_];

  // The chord h = dS sinc(dPsi/2) of (M-arc), or h = dS of (M-1), along theta + alpha + dtheta/2, written as
  // the twist that (M-exp) turns into it: q = h / sinc(dtheta/2).
  const double half = 0.5 * axle.heading;
  const double half_psi = half + 0.5 * alpha_change;
  const double arc = sinc(half);
  const double chord = paper ? 1.0 : sinc(half_psi);
  const double chord_slope = paper ? 0.0 : 0.5 * sincDerivative(half_psi);
  const double ratio = chord / arc;
  const double ratio_slope = (chord_slope - 0.5 * ratio * sincDerivative(half)) / arc;
  const double q = axle.travel * ratio;
  const double c = std::cos(alpha);
  const double s = std::sin(alpha);
  const double a = vehicle_.axleX(axle_);

  motion << q * c, q * s - a * axle.heading, axle.heading;
  Eigen::Matrix<double, 3, 2> J_motion_axle;
  J_motion_axle << ratio * c, axle.travel * ratio_slope * c,  //
      ratio * s, axle.travel * ratio_slope * s - a,           //
      0.0, 1.0;
  Eigen::Matrix<double, 3, 4> J = J_motion_axle * axle.J;
  J.col(kAlpha) += Eigen::Vector3d(-q * s, q * c, 0.0);
  return J;
}

void AxleOdometry::update(const StepReadings& readings, BodyIncrement& increment) const {
  increment = BodyIncrement();
  const Eigen::Matrix<double, 3, 4> J = setMotion(readings, increment.motion);
  addCovariances(readings, J, increment);
  setSensitivity(readings, J, increment);
}

BodyMotion AxleOdometry::motion(const StepReadings& readings) const {
  BodyMotion motion;
  setMotion(readings, motion);
  return motion;
}

StepNoise AxleOdometry::noiseSources(const StepReadings& readings) const {
  BodyMotion motion;
  const Eigen::Matrix<double, 3, 4> J = setMotion(readings, motion);
  const Wheel right = rightWheel(axle_);
  const Wheel left = leftWheel(axle_);
  StepNoise noise;
  noise.wheel_path[right] = std::abs(readings.travel[right]);
  noise.wheel_path[left] = std::abs(readings.travel[left]);
  noise.J_motion_wheel.col(static_cast<Eigen::Index>(index(right))) = J.col(kRight);
  noise.J_motion_wheel.col(static_cast<Eigen::Index>(index(left))) = J.col(kLeft);
  const double alpha = readings.mean()[axle_];
  noise.J_motion_slip.col(static_cast<Eigen::Index>(index(axle_))) << -std::sin(alpha), std::cos(alpha), 0.0;
  noise.axle_path.front = noise.axle_path.rear = 0.5 * (noise.wheel_path[right] + noise.wheel_path[left]);
  return noise;
}

/// Noise of one step (docs/model.md, section 5.1). The error of the angle lasts for its correlation length:
/// over a drive it adds up like one of variance l/d that is fresh in each step, but in the one step it is no
/// larger than itself.
void AxleOdometry::addCovariances(const StepReadings& readings, const Eigen::Matrix<double, 3, 4>& J,
                                  BodyIncrement& increment) const {
  const double right = std::abs(readings.travel[rightWheel(axle_)]);
  const double left = std::abs(readings.travel[leftWheel(axle_)]);
  const double d = 0.5 * (right + left);
  const double wheel_variance = noise_.wheel.variance();
  const auto outer = [&J](int column) { return Eigen::Matrix3d(J.col(column) * J.col(column).transpose()); };
  const Eigen::Matrix3d right_outer = outer(kRight);
  const Eigen::Matrix3d left_outer = outer(kLeft);
  const auto rounding = [this](Wheel wheel) {
    const double tick = vehicle_.calibratedMetresPerTick(wheel);
    return tick * tick / 6.0;
  };
  increment.step_covariance =
      rounding(rightWheel(axle_)) * right_outer + rounding(leftWheel(axle_)) * left_outer;
  if (d <= 0.0) return;
  double steering = noise_.steering.angle.variance();
  if (axle_ == Axle::kRear && vehicle_.rear_steering.source == RearSteering::Source::kPolynomial) {
    const double slope = vehicle_.rear_steering.slope(readings.mean().front);
    steering = steering * slope * slope + noise_.rear_law.variance();
  }
  const double alpha = readings.mean()[axle_];
  const Eigen::Vector3d sideways(-std::sin(alpha), std::cos(alpha), 0.0);
  const Eigen::Matrix3d fresh = wheel_variance * (right * right_outer + left * left_outer) +
                                noise_.lateral.variance() * d * sideways * sideways.transpose();
  const Eigen::Matrix3d steered = steering * outer(kAlpha);
  const double lengths = noise_.steering.correlation_length / d;
  increment.path_covariance = fresh + lengths * steered;
  increment.step_covariance += fresh + std::min(lengths, 1.0) * steered;
}

void AxleOdometry::setSensitivity(const StepReadings& readings, const Eigen::Matrix<double, 3, 4>& J,
                                  BodyIncrement& increment) const {
  using namespace systematic;
  SystematicSensitivity& S = increment.J_motion_systematic;
  const AxleGains& gains = vehicle_.gains[axle_];
  const bool rear = axle_ == Axle::kRear;
  S.col(rear ? kRearRight : kFrontRight) = J.col(kRight) * (readings.travel[rightWheel(axle_)] / gains.k_r);
  S.col(rear ? kRearLeft : kFrontLeft) = J.col(kLeft) * (readings.travel[leftWheel(axle_)] / gains.k_l);
  S.col(rear ? kRearTrack : kFrontTrack) = J.col(kTrack) * vehicle_.track[axle_];
  if (!rear) {
    S.col(kFrontOffset) = J.col(kAlpha);
  } else if (vehicle_.rear_steering.source == RearSteering::Source::kPolynomial) {
    S.col(kFrontOffset) = J.col(kAlpha) * vehicle_.rear_steering.slope(readings.mean().front);
  } else {
    S.col(kRearOffset) = J.col(kAlpha);
  }
}

}  // namespace bs_car_odometry
