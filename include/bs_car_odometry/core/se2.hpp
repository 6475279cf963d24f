#pragma once

#include <Eigen/Core>

#include <cmath>

namespace bs_car_odometry {

/// sin(u)/u, without loss of digits at any u. The steps of a car have small angles, for which the series
/// takes no sine; its first missing term is below 1e-16 at the switch.
inline double sinc(double u) {
  if (std::abs(u) > 0.3) return std::sin(u) / u;
  const double u2 = u * u;
  return 1.0 - u2 / 6.0 * (1.0 - u2 / 20.0 * (1.0 - u2 / 42.0 * (1.0 - u2 / 72.0 * (1.0 - u2 / 110.0))));
}

/// Derivative of sinc: (cos(u) - sinc(u))/u. The difference loses u^-2 in digits, so the series is taken
/// early; its first missing term is below 1e-16 of the result at the switch.
inline double sincDerivative(double u) {
  if (std::abs(u) > 0.3) return (std::cos(u) - std::sin(u) / u) / u;
  const double u2 = u * u;
  return -u / 3.0 *
         (1.0 - u2 / 10.0 * (1.0 - u2 / 28.0 * (1.0 - u2 / 54.0 * (1.0 - u2 / 88.0 * (1.0 - u2 / 130.0)))));
}

/// Angle in [-pi, pi].
inline double wrapAngle(double angle) { return std::remainder(angle, 2.0 * M_PI); }

/// Planar pose of a frame in another, or the transform between them.
struct Pose2 {
  double x{0.0};    ///< [m]
  double y{0.0};    ///< [m]
  double yaw{0.0};  ///< [rad], counter-clockwise, not wrapped

  Eigen::Vector2d position() const { return {x, y}; }
  Eigen::Vector3d vector() const { return {x, y, yaw}; }
  bool isFinite() const { return std::isfinite(x) && std::isfinite(y) && std::isfinite(yaw); }
};

/// T_ac = T_ab * T_bc.
inline Pose2 operator*(const Pose2& ab, const Pose2& bc) {
  const double c = std::cos(ab.yaw);
  const double s = std::sin(ab.yaw);
  return {ab.x + c * bc.x - s * bc.y, ab.y + s * bc.x + c * bc.y, ab.yaw + bc.yaw};
}

inline Pose2 inverse(const Pose2& ab) {
  const double c = std::cos(ab.yaw);
  const double s = std::sin(ab.yaw);
  return {-c * ab.x - s * ab.y, s * ab.x - c * ab.y, -ab.yaw};
}

/// Motion of the body over one step: travel along x and y of the body [m] and heading increment [rad], the
/// twist times the duration when the twist is constant.
using BodyMotion = Eigen::Vector3d;

/// (M-exp) Where a constant twist takes the body: the SE(2) exponential of t = (ux, uy, dtheta),
///     [dx]   [a -b] [ux]
///     [dy] = [b  a] [uy],   a = sin(dtheta)/dtheta,  b = (1 - cos(dtheta))/dtheta,
/// written with the half angle, (a, b) = sinc(dtheta/2) (cos(dtheta/2), sin(dtheta/2)), where nothing
/// cancels.
inline Pose2 exp(const BodyMotion& t) {
  const double half = 0.5 * t.z();
  const double chord = sinc(half);
  const double a = chord * std::cos(half);
  const double b = chord * std::sin(half);
  return {a * t.x() - b * t.y(), b * t.x() + a * t.y(), t.z()};
}

/// Inverse of exp for |yaw| < 2 pi.
inline BodyMotion log(const Pose2& pose) {
  const double half = 0.5 * pose.yaw;
  const double inverse_chord = 1.0 / sinc(half);
  const double c = std::cos(half) * inverse_chord;
  const double s = std::sin(half) * inverse_chord;
  return {c * pose.x + s * pose.y, c * pose.y - s * pose.x, pose.yaw};
}

/// One step of a pose by a body motion, with what the covariance needs of it.
struct PoseStep {
  Pose2 pose;      ///< T_odom_base after the step
  double dx{0.0};  ///< [m] displacement in odom
  double dy{0.0};  ///< [m]
  /// Derivative of the new pose with respect to (ux, uy, dtheta); its last row is (0, 0, 1):
  ///     J = [ r -s  p; s  r  q; 0  0  1 ]
  double r{1.0}, s{0.0}, p{0.0}, q{0.0};

  Eigen::Matrix3d J_pose_motion() const {
    Eigen::Matrix3d J;
    J << r, -s, p, s, r, q, 0.0, 0.0, 1.0;
    return J;
  }
  /// F = [1 0 -dy; 0 1 dx; 0 0 1]: derivative of the new pose with respect to the old one.
  Eigen::Matrix3d J_pose_pose() const {
    Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
    F(0, 2) = -dy;
    F(1, 2) = dx;
    return F;
  }
};

/// pose * exp(t) and its Jacobians. With h = dtheta/2 and the direction psi = yaw + h the displacement is
/// d = sinc(h) R(psi) u, so dd/du = sinc(h) R(psi) and dd/ddtheta = (sinc'(h) R(psi) u + rotate90(d))/2.
inline PoseStep advance(const Pose2& pose, const BodyMotion& t) {
  const double half = 0.5 * t.z();
  const double psi = pose.yaw + half;
  const double c = std::cos(psi);
  const double s = std::sin(psi);
  const double chord = sinc(half);
  const double along = c * t.x() - s * t.y();
  const double across = s * t.x() + c * t.y();

  PoseStep step;
  step.dx = chord * along;
  step.dy = chord * across;
  const double slope = sincDerivative(half);
  step.r = chord * c;
  step.s = chord * s;
  step.p = 0.5 * (slope * along - step.dy);
  step.q = 0.5 * (slope * across + step.dx);
  step.pose = {pose.x + step.dx, pose.y + step.dy, pose.yaw + t.z()};
  return step;
}

}  // namespace bs_car_odometry
