#pragma once

#include "bs_car_odometry/core/se2.hpp"

#include <Eigen/Core>

#include <complex>

namespace bs_car_odometry {

/// One step for the moments of the pose: displacement D e^{i (theta + direction eta)} and turn eta, where
/// D = Dx + i Dy and eta are jointly Gaussian and independent of the past.
struct GaussianStep {
  std::complex<double> displacement;  ///< mean of D [m], in body axes
  double turn{0.0};                   ///< mean of eta [rad]
  Eigen::Matrix3d covariance;         ///< of (Dx, Dy, eta)
  /// Share of its own turn that the displacement is turned by: 1/2 for an arc, 0 for P2's Euler step.
  double direction{0.5};

  /// The step of a body motion t with covariance P. Only D = sinc(eta/2) (ux + i uy) is linearised, with a
  /// relative error of about Var(eta)/24.
  static GaussianStep ofBody(const BodyMotion& t, const Eigen::Matrix3d& P);
};

/// First and second moments of a pose that is moved by independent Gaussian steps (docs/model.md, S4'). The
/// heading stays Gaussian, so they follow exactly from a few running numbers, in central form, which loses no
/// digits far from the origin. Complex numbers are plane vectors x + i y.
class PoseMoments {
 public:
  /// Starts from a Gaussian pose.
  void reset(const Pose2& mean, const Eigen::Matrix3d& covariance);

  void advance(const GaussianStep& step);

  /// Adds an independent Gaussian error of the pose.
  void add(const Eigen::Matrix3d& covariance);

  /// Forgets everything but mean and covariance, as P2 does at every step (S3).
  void makeGaussian();

  /// Expected pose. Its position lags behind the dead-reckoned one, as a heading that spreads attenuates
  /// every step.
  Pose2 mean() const { return {mean_.real(), mean_.imag(), heading_}; }

  Eigen::Matrix3d covariance() const;

 private:
  using Complex = std::complex<double>;

  Complex mean_;                ///< a = E[z]
  double heading_{0.0};         ///< m = E[theta]
  double heading_variance_{0};  ///< s2
  double var_x_{0.0};           ///< (M + Re W)/2
  double var_y_{0.0};           ///< (M - Re W)/2
  double cov_xy_{0.0};          ///< Im W/2
  Complex position_heading_;    ///< T = E[dz dtheta]
  Complex backward_;            ///< p = E[dz e^{-i dtheta}]
  Complex forward_;             ///< q = E[dz e^{+i dtheta}]
};

}  // namespace bs_car_odometry
