#pragma once

#include "bs_car_odometry/core/kinematics.hpp"
#include "bs_car_odometry/core/se2.hpp"
#include "bs_car_odometry/core/wheels_and_axles.hpp"

#include <Eigen/Core>

namespace bs_car_odometry {

/// Parameters whose errors stay the same for the whole drive, p(A) of P1, in the order of every covariance
/// over them (docs/interface.md, systematic parameters).
namespace systematic {
enum Index {
  kFrontRight,   ///< front/k_r
  kFrontLeft,    ///< front/k_l
  kFrontTrack,   ///< front/k_b
  kFrontOffset,  ///< front/steering_offset [rad]
  kRearRight,
  kRearLeft,
  kRearTrack,
  kRearOffset,
  kCount
};
}  // namespace systematic

using SystematicCovariance = Eigen::Matrix<double, systematic::kCount, systematic::kCount>;
/// Row by row in memory: the propagation works on whole rows.
using SystematicSensitivity = Eigen::Matrix<double, 3, systematic::kCount, Eigen::RowMajor>;

/// What one step is computed from.
struct StepReadings {
  PerWheel<double> travel;  ///< S = k zeta dN [m], forward positive; 0 where the wheel has no encoder
  SteeringAngles begin;     ///< angles of the axles at both ends of the step, after scale and offset
  SteeringAngles end;
  PerWheel<bool> left_out;  ///< wheels with an encoder that must not be believed in this step
  /// Standard deviation of each sensor's angle [rad] beyond its noise; 0 where it is trusted.
  PerAxle<double> steering_doubt;

  bool isDoubted() const { return steering_doubt.front > 0.0 || steering_doubt.rear > 0.0; }
  bool leavesOut() const {
    return left_out.values[0] || left_out.values[1] || left_out.values[2] || left_out.values[3];
  }

  SteeringAngles mean() const { return {0.5 * (begin.front + end.front), 0.5 * (begin.rear + end.rear)}; }
};

/// How well the readings of a step agree (docs/model.md, W1); all zero when nothing is left over.
struct FitResiduals {
  PerWheel<double> wheel;  ///< [m] measured minus fitted travel, also of wheels that were left out
  PerAxle<double> axle;    ///< [m] sideways travel against the steering angle
  double chi_square{0.0};
  int degrees_of_freedom{0};
};

/// Motion of base_link over one step, with its uncertainty. Every odometry of this package, one axle or all
/// wheels, answers with one of these; one integrator and one covariance propagation serve them all.
struct BodyIncrement {
  BodyMotion motion{BodyMotion::Zero()};  ///< t = (ux, uy, dtheta) at base_link
  /// Covariance of t from independent noise that adds up over the drive: K R_0 K^T.
  Eigen::Matrix3d path_covariance{Eigen::Matrix3d::Zero()};
  /// Covariance of t alone, rounding of the counters included: for the twist.
  Eigen::Matrix3d step_covariance{Eigen::Matrix3d::Zero()};
  SystematicSensitivity J_motion_systematic{SystematicSensitivity::Zero()};  ///< dt/dA
  FitResiduals residuals;
};

}  // namespace bs_car_odometry
