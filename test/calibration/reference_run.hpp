#pragma once

#include <Eigen/Core>

#include <functional>
#include <vector>

/// The calibration runs whose bounds are known (docs/calibration.md, 5): a Cycab's rear axle at 50 Hz, with
/// wheels that roll as the Ackermann geometry makes them, and a path that is (M-1) with model A of these
/// travels, so that whoever uses that model has exactly the model of the data.
namespace bs_car_odometry::calibration::reference {

constexpr double kTrack = 1.2;      ///< B, nominal [m]
constexpr double kWheelbase = 1.2;  ///< L [m]
constexpr double kRightGain = 1.02;
constexpr double kLeftGain = 0.99;
constexpr double kTrackGain = 1.03;
constexpr double kPeriod = 0.02;    ///< [s]
constexpr int kLaserEvery = 5;      ///< samples, from the first one on
constexpr double kWheel = 0.005;    ///< c [m/sqrt(m)]
constexpr double kRounding = 1e-5;  ///< [m], a step
constexpr double kAngle = 0.003;    ///< [rad], a step

/// What a step of the run consists of.
struct Step {
  double right{0.0};  ///< true travels S_r, S_l [m]
  double left{0.0};
  double alpha{0.0};       ///< true angle of the rear axle: mean of both ends [rad]
  Eigen::Vector3d before;  ///< true pose of R (x, y, theta) at both ends
  Eigen::Vector3d after;
  Eigen::Vector3d velocity{
      Eigen::Vector3d::Zero()};  ///< of R at the end, central difference of the poses [m/s, m/s, rad/s]
  double distance{0.0};          ///< mean of both wheels, from the start to the end [m]
  bool laser{false};             ///< one is taken at the end
};

/// Speed of R and front angle over time.
struct Commands {
  std::function<double(double)> speed;
  std::function<double(double)> angle;
};

Commands fifteenSeconds();
/// Eights: phi = 0.4 sin(2 pi t/20) at 1 m/s.
Commands slalomEight();

std::vector<Step> drive(const Commands& commands, double duration);

/// Derivatives of (M-1) with model A at the true values (docs/model.md, 4).
struct Linearised {
  Eigen::Matrix3d F;         ///< d pose' / d pose
  Eigen::Matrix3d G;         ///< d pose' / d (S_r, S_l, alpha)
  Eigen::Matrix3d J;         ///< d pose' / d (k_r, k_l, k_b)
  Eigen::Vector3d variance;  ///< of S_r, S_l, alpha
  Eigen::Matrix3d Q() const { return G * variance.asDiagonal() * G.transpose(); }
};

Linearised linearise(const Step& step);

/// Of a laser pose: 0.02 m and 0.005 rad.
Eigen::Matrix3d laserCovariance();

}  // namespace bs_car_odometry::calibration::reference
