#pragma once

#include "vehicles.hpp"

#include "bs_car_odometry/core/moment_uncertainty.hpp"

#include <Eigen/Core>

#include <cmath>
#include <cstddef>
#include <vector>

// The experiment of P2: its robot and its rectangle (docs/model.md, T13).
namespace bs_car_odometry::test_support {

constexpr double kPaper2Track = 0.4;  ///< b [m]; P2 does not give it

/// Covariance of (D, eta) of a differential robot, as P of a body motion (D, 0, eta).
inline Eigen::Matrix3d differentialNoise(double sigma_right, double sigma_left, double track) {
  Eigen::Matrix<double, 3, 2> J;
  J << 0.5, 0.5, 0.0, 0.0, 1.0 / track, -1.0 / track;
  const Eigen::Vector2d variances(sigma_right * sigma_right, sigma_left * sigma_left);
  return J * variances.asDiagonal() * J.transpose();
}

struct WheelTravels {
  double right;
  double left;
};

/// 10 m x 4.5 m, 0.01 m a step, turns of 90 degrees on the spot after every leg: 3152 steps.
inline std::vector<WheelTravels> rectangle() {
  std::vector<WheelTravels> steps;
  const double turn = kPaper2Track * (0.5 * M_PI) / 126.0;
  for (const int leg : {1000, 450, 1000, 450}) {
    steps.insert(steps.end(), static_cast<std::size_t>(leg), {0.01, 0.01});
    steps.insert(steps.end(), 63, {turn, -turn});
  }
  return steps;
}

/// The body motion of a step (M-1), for which T13 is stated: a chord of dS and not an arc.
/// @param sigma  noise of each wheel and step [m]
inline BodyIncrement chordOf(const WheelTravels& wheels, double sigma) {
  BodyIncrement increment;
  const double turn = (wheels.right - wheels.left) / kPaper2Track;
  const double per_chord = 1.0 / sinc(0.5 * turn);
  increment.motion << 0.5 * (wheels.right + wheels.left) * per_chord, 0.0, turn;
  const Eigen::Vector3d scale(per_chord, 1.0, 1.0);  // on the spot dS = 0, so that eta changes nothing else
  increment.path_covariance =
      scale.asDiagonal() * differentialNoise(sigma, sigma, kPaper2Track) * scale.asDiagonal();
  return increment;
}

/// The reference values are covariances about the mean; exact moments publish those about the dead-reckoned
/// pose.
inline Eigen::Matrix3d aboutTheMean(const PoseUncertainty& method) {
  const auto* exact = dynamic_cast<const ExactMoments*>(&method);
  return exact != nullptr ? exact->central() : method.total();
}

/// Drives the rectangle; `check(step, covariance)` sees the covariance about the mean after every step,
/// counted from 1.
template <typename Check>
void driveRectangle(PoseUncertainty& method, double sigma, const Check& check) {
  const OdometryModel model = WheelFit(cycab(), NoiseModel());
  Pose2 pose;
  method.reset(pose, Eigen::Matrix3d::Zero());
  std::size_t count = 0;
  for (const WheelTravels& wheels : rectangle()) {
    const BodyIncrement increment = chordOf(wheels, sigma);
    const PoseStep moved = advance(pose, increment.motion);
    method.advance({moved, increment, SystematicSensitivity::Zero(), {}, model});
    pose = moved.pose;
    check(++count, aboutTheMean(method));
  }
}

}  // namespace bs_car_odometry::test_support
