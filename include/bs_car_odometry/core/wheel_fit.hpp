#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/core/step_noise.hpp"
#include "bs_car_odometry/core/vehicle.hpp"

#include <Eigen/Core>

namespace bs_car_odometry {

/// Where the wheels of (W1) are, worked out once for a vehicle.
struct FitGeometry {
  explicit FitGeometry(const Vehicle& vehicle);

  Eigen::Array4d x;  ///< kingpins in base_link [m]
  Eigen::Array4d y;
  Eigen::Array4d outward;  ///< e_i h [m]: hub offset, positive on the left, negative on the right
  Eigen::Array2d axle_x;   ///< a_f, a_r [m]
  double per_wheelbase;    ///< 1/L [1/m]
  bool parallel_wheels;    ///< pivot axles
  bool hub_offset;         ///< some wheel has one
};

/// One row for each equation of (W1): wheels fl fr rl rr, axles front rear.
template <int Columns>
using FitMatrix = Eigen::Matrix<double, kWheels + kAxles, Columns>;

/// The six equations of (W1) for t = (ux, uy, dtheta):
///     wheel  S_i = cos(delta_i) ux + sin(delta_i) uy + (x_i sin(delta_i) - y_i cos(delta_i) - e_i h) dtheta
///     axle   0   = -sin(phi_j) ux + cos(phi_j) uy + a_j cos(phi_j) dtheta
struct FitEquations {
  FitMatrix<3> H;
  // How far all of them travel together, (W2), for a vx of cos(phi_f) cos(phi_r):
  Eigen::Array4d path_ratio;  ///< rho_i of the wheels
  Eigen::Array2d axle_ratio;  ///< of the axles
};

/// R of (W1), or its inverse: independent wheels (a variance of infinity leaves the wheel out) and two axles
/// that may share the error of one steering sensor.
struct FitCovariance {
  Eigen::Array4d wheels;  ///< [m^2]
  Eigen::Array2d axles;   ///< [m^2]
  double shared;          ///< covariance of the axles [m^2]
};

FitCovariance inverse(const FitCovariance& R);

/// R M.
template <int Columns>
inline FitMatrix<Columns> operator*(const FitCovariance& R, const FitMatrix<Columns>& M) {
  FitMatrix<Columns> product;
  for (Eigen::Index j = 0; j < Columns; ++j) {
    const auto axles = M.col(j).template tail<2>().array();
    product.col(j).template head<4>() = R.wheels * M.col(j).template head<4>().array();
    product.col(j).template tail<2>() = R.axles * axles + R.shared * axles.reverse();
  }
  return product;
}

/// t = K y with K = (H^T R^-1 H)^-1 H^T R^-1 and P = (H^T R^-1 H)^-1. K is kept transposed, one column for
/// each unknown, so that the equations are worked on two by two.
struct FitSolution {
  BodyMotion motion;
  Eigen::Matrix3d P;
  FitMatrix<3> Kt;
  FitMatrix<1> residual;  ///< r = y - H t [m]
  double chi_square;      ///< r^T R^-1 r
};

/// What the readings of a step say of the parameters whatever the motion was: six equations leave three over.
/// About the parameters' present values, an error dA of them has the likelihood
///     exp(-dA^T information dA / 2 + gradient^T dA)      (docs/calibration.md, 2)
struct ParameterEvidence {
  using Gradient = Eigen::Matrix<double, systematic::kCount, 1>;
  SystematicCovariance information;  ///< D^T M D, M = R^-1 - R^-1 H P H^T R^-1, D = dy/dA - dH/dA t
  Gradient gradient;                 ///< -D^T R^-1 r
  double chi_square;                 ///< of the step
};

/// Rows of (W1) for the mean angles of a step.
FitEquations fitEquations(const FitGeometry& geometry, const SteeringAngles& steering);

/// (W1) for the wheel travels [m]; the sideways travel of the axles is zero.
FitSolution solveFit(const FitMatrix<3>& H, const FitCovariance& R, const Eigen::Vector4d& travels);

/// w_i = (R^-1 r)_i / sqrt(M_ii), M = R^-1 - R^-1 H P H^T R^-1: standard normal when all is well, and largest
/// where one reading is wrong (docs/model.md, section 6).
FitMatrix<1> normalisedResiduals(const FitMatrix<3>& H, const FitCovariance& R, const FitSolution& solution);

/// Odometry from every wheel that has an encoder and both steering angles, weighted least squares
/// (docs/model.md, section 6). Wheels that the readings leave out have no weight, and axles whose angle is
/// doubted the less the more it is.
class WheelFit {
 public:
  WheelFit(const Vehicle& vehicle, const NoiseModel& noise);

  BodyIncrement increment(const StepReadings& readings) const {
    BodyIncrement increment;
    update(readings, increment);
    return increment;
  }

  /// The same into an increment that exists: no copy in every step.
  void update(const StepReadings& readings, BodyIncrement& increment) const;

  /// The motion of update() alone.
  BodyMotion motion(const StepReadings& readings) const;

  /// The noise that update() sums up, source by source.
  StepNoise noiseSources(const StepReadings& readings) const;

  /// What is left over by update(), for a calibration.
  ParameterEvidence evidence(const StepReadings& readings) const;

 private:
  /// The wheels that a step may use.
  struct Believed {
    Eigen::Array4d wheels;    ///< 1, or 0
    Eigen::Array4d rounding;  ///< variance of the counters' rounding [m^2], infinite for the others
  };
  /// Everything that leads to the motion of a step.
  struct Solved {
    double rear_slope;
    Believed believed;
    FitEquations equations;
    double travel;
    FitCovariance path_noise;  ///< R_0
    FitCovariance R;
    FitSolution fit;
  };
  Solved solve(const StepReadings& readings) const;
  Believed believed(const StepReadings& readings) const;
  Eigen::Array4d measuredTravels(const StepReadings& readings) const;
  double commonTravel(const FitEquations& equations, const StepReadings& readings,
                      const Believed& believed) const;
  FitCovariance pathNoise(const FitEquations& equations, double travel, double rear_slope,
                          const Believed& believed) const;
  FitCovariance doubt(const FitEquations& equations, double travel, double rear_slope,
                      const PerAxle<double>& sigma) const;
  FitCovariance weighting(const Solved& solved, const StepReadings& readings) const;
  void setResiduals(const Solved& solved, const StepReadings& readings, FitResiduals& residuals) const;
  void setStepCovariance(const Solved& solved, const StepReadings& readings,
                         Eigen::Matrix3d& step_covariance) const;
  void subtractSteeringOfOtherSteps(const FitSolution& fit, const Eigen::Array2d& V,
                                    const FitCovariance& path_noise, Eigen::Matrix3d& step_covariance) const;
  /// Derivatives of the equations by the axles' angles.
  struct SteeringEffect {
    Eigen::Array2d along;   ///< of the axles' rows [m]: how far they travel along their angle
    Eigen::Array4d across;  ///< of the wheels' rows [m]: how far those of parallel wheels slide
  };
  SteeringEffect steeringEffect(const FitMatrix<3>& H, const BodyMotion& t) const;
  FitMatrix<systematic::kCount> J_equations(const Solved& solved, const StepReadings& readings) const;
  Eigen::Matrix<double, 2, 3> J_motion_steering(const FitMatrix<3>& H, const FitSolution& fit) const;
  void setSensitivity(const FitMatrix<3>& H, const FitSolution& fit, const StepReadings& readings,
                      double rear_slope, SystematicSensitivity& J) const;

  Vehicle vehicle_;
  FitGeometry geometry_;
  Eigen::Array4d used_;            ///< 1 for a wheel with an encoder, else 0
  Eigen::Array4d rounding_;        ///< variance of the counters' rounding [m^2], infinite without an encoder
  Eigen::Array4d per_gain_;        ///< 1/k_i: measured travel before its gain
  Eigen::Array4d half_track_;      ///< B/2 of the wheel's axle [m]
  double wheel_variance_;          ///< variances for each metre of travel: of a wheel [m^2/m],
  double lateral_variance_;        ///< of an axle's side slip,
  double sensor_variance_;         ///< of its angle's error times its travel,
  double law_variance_;            ///< of the rear law's error times the rear axle's travel
  double per_correlation_length_;  ///< of both [1/m]
  int wheels_used_;
  bool shared_sensor_;  ///< the rear angle follows from the front reading
};

}  // namespace bs_car_odometry
