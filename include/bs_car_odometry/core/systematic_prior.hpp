#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/odometry_configuration.hpp"
#include "bs_car_odometry/core/se2.hpp"

#include <Eigen/Core>

#include <array>

namespace bs_car_odometry {

/// p(A) in the form A = L a with independent a of variance 1: Sigma_A = L L^T, L lower triangular.
/// Sensitivities are carried as those to a, so that the share of the parameters is J L (J L)^T: half the work
/// of J Sigma_A J^T, and positive semidefinite whatever the rounding.
class SystematicRoot {
 public:
  /// @param covariance  Sigma_A, positive semidefinite; a variance of zero is a parameter known exactly
  explicit SystematicRoot(const SystematicCovariance& covariance);

  /// J L.
  SystematicSensitivity operator()(const SystematicSensitivity& J) const;

  SystematicCovariance matrix() const;

  /// From A back to a; zero for what is known exactly.
  SystematicCovariance inverse() const;

 private:
  using Block = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  Block front_;  ///< blocks of L: parameters of the front axle, then of the rear axle
  Block rear_front_;
  Block rear_;
};

/// What is believed of the parameters before the drive.
struct SystematicPrior {
  /// As configured: the noise model's independent parameters, each axle with its own (docs/interface.md), or
  /// a calibration's covariance.
  explicit SystematicPrior(const OdometryConfiguration& configuration);
  /// Gaussian, but for parameters that are as independent and uncertain as the noise model says.
  SystematicPrior(const SystematicCovariance& covariance, const OdometryConfiguration& configuration);

  SystematicRoot root;
  std::array<Distribution, systematic::kCount> shape;  ///< of the components of a, but for their scale
  std::array<bool, systematic::kCount> active;         ///< components of a that can move the car
};

/// Sigma_A of a noise model.
SystematicCovariance systematicCovariance(const SystematicNoise& noise);
/// Sigma_A of a configuration.
SystematicCovariance systematicCovariance(const OdometryConfiguration& configuration);

/// How much of the errors a of the parameters is still in their errors a' after other values and another
/// Sigma_A have taken their place (docs/calibration.md, C40): M = E[a a'^T]. A calibration takes away an
/// error that it has found and that is independent of what it leaves, so that E[A A'^T] is Sigma_A after it;
/// where Sigma_A grew, it is Sigma_A before.
SystematicCovariance carriedOver(const SystematicRoot& before, const SystematicRoot& after);

/// Phi a = Phi M a' and a rest that is independent of a'.
/// @param sensitivity  Phi, then Phi M
/// @return covariance of the rest
Eigen::Matrix3d carryOver(const SystematicCovariance& M, SystematicSensitivity& sensitivity);

/// Phi' = F Phi + G dt/da: sensitivity of the pose to the parameters after one more step.
template <int Columns>
inline void advanceSensitivity(const PoseStep& step,
                               const Eigen::Matrix<double, 3, Columns, Eigen::RowMajor>& J_motion,
                               Eigen::Matrix<double, 3, Columns, Eigen::RowMajor>& sensitivity) {
  const auto& J = J_motion;  // row by row
  sensitivity.row(0) +=
      step.r * J.row(0) - step.s * J.row(1) + step.p * J.row(2) - step.dy * sensitivity.row(2);
  sensitivity.row(1) +=
      step.s * J.row(0) + step.r * J.row(1) + step.q * J.row(2) + step.dx * sensitivity.row(2);
  sensitivity.row(2) += J.row(2);
}

/// total = scale (noise + J J^T): a covariance with the share of the parameters, from the sensitivity J to a.
void setTotal(const Eigen::Matrix3d& noise, const SystematicSensitivity& J, double scale,
              Eigen::Matrix3d& total);

}  // namespace bs_car_odometry
