#pragma once

#include <Eigen/Core>

namespace bs_car_odometry::calibration {

/// Standard deviation of what nothing is known of. In information form it costs no digits.
constexpr double kDiffuse = 1e6;

/// The smallest covariance that any unbiased estimator of pose and parameters can have, given the noise model
/// (docs/calibration.md, 5): the recursion of a Kalman filter, linearised at the truth. Noise of the motion
/// is marginalised. With a prior it is the Bayesian bound. Carried as a root W of the information, W^T W, so
/// that a diffuse beginning and steps without noise are as exact as any other.
class CramerRaoBound {
 public:
  using PoseSensitivity = Eigen::Matrix<double, 3, Eigen::Dynamic>;

  /// The pose is not known at the beginning.
  /// @param prior  standard deviations of the parameters, positive; kDiffuse for no prior
  explicit CramerRaoBound(const Eigen::VectorXd& prior);

  /// Moves on: pose' = f(pose, parameters) + noise.
  /// @param F  d pose' / d pose, invertible
  /// @param J  d pose' / d parameters
  /// @param Q  covariance of the noise (x, y, yaw), may be singular
  void predict(const Eigen::Matrix3d& F, const PoseSensitivity& J, const Eigen::Matrix3d& Q);

  /// A measurement of (x, y, yaw) kind.
  /// @param H_pose        d measurement / d pose
  /// @param H_parameters  d measurement / d parameters
  /// @param R             its covariance, positive definite
  void update(const Eigen::Matrix3d& H_pose, const PoseSensitivity& H_parameters, const Eigen::Matrix3d& R);

  /// What is known of the parameters from elsewhere.
  /// @param information  positive semidefinite
  void add(const Eigen::MatrixXd& information);

  /// Of (pose, parameters).
  Eigen::MatrixXd covariance() const;

  /// Standard deviations of the parameters; about kDiffuse where nothing shows them.
  Eigen::VectorXd deviations() const;

 private:
  Eigen::Index parameters() const { return root_.cols() - 3; }

  Eigen::MatrixXd root_;  ///< W, upper triangular
};

}  // namespace bs_car_odometry::calibration
