#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/core/step_noise.hpp"
#include "bs_car_odometry/core/vehicle.hpp"

namespace bs_car_odometry {

/// Motion of an axle's middle over one step, with its derivatives.
struct AxleMotion {
  double travel{0.0};   ///< dS [m], along the path
  double heading{0.0};  ///< dtheta [rad]
  /// Derivatives of (dS, dtheta) with respect to (S_r, S_l, alpha, B).
  Eigen::Matrix<double, 2, 4> J{Eigen::Matrix<double, 2, 4>::Zero()};
};

/// (A) and (H), parallel wheels at `alpha`, exact:
///     dS = (S_r + S_l)/2,  dtheta = (S_r - S_l - 2 h d_alpha)/((B - 2h) cos(alpha) + 2h)
/// @param right, left  travels S_r, S_l [m]
/// @param alpha        mean steering angle of the axle over the step [rad]
/// @param alpha_change d_alpha [rad]
/// @param track        B [m]
/// @param hub_offset   h [m]
AxleMotion pivotAxle(double right, double left, double alpha, double alpha_change, double track,
                     double hub_offset);

/// P1's trace "Odometry 2": as (A), but with B in the place of B cos(alpha).
AxleMotion unshortenedAxle(double right, double left, double track);

/// (B), each wheel rolling along its own velocity, exact. Outside its domain (a wheel at rest or reversed
/// while the other turns) answers with (A).
AxleMotion ackermannAxle(double right, double left, double alpha, double track);

/// (C), wheel directions known [rad]:
///     S_r = dS cos(delta_r - alpha) + (B/2) dtheta cos(delta_r)
///     S_l = dS cos(delta_l - alpha) - (B/2) dtheta cos(delta_l)
/// J holds the derivatives with respect to S_r and S_l; those with respect to alpha and B stay zero.
AxleMotion directedAxle(double right, double left, double alpha, double delta_right, double delta_left,
                        double track);

/// Odometry from the two wheels of one axle, the papers' (docs/model.md, section 3).
class AxleOdometry {
 public:
  AxleOdometry(const Vehicle& vehicle, const NoiseModel& noise, const OdometryOptions& options, Axle axle);

  BodyIncrement increment(const StepReadings& readings) const {
    BodyIncrement increment;
    update(readings, increment);
    return increment;
  }

  /// The same into an increment that exists: no copy in every step.
  void update(const StepReadings& readings, BodyIncrement& increment) const;

  /// The motion of update() alone.
  BodyMotion motion(const StepReadings& readings) const;

  /// The noise that update() sums up, source by source. Both axles' angles go by the path of this one, the
  /// only one that is known.
  StepNoise noiseSources(const StepReadings& readings) const;

  /// (dS, dtheta) of the axle's middle, derivatives with respect to (S_r, S_l, alpha, B).
  AxleMotion axleMotion(const StepReadings& readings) const;

 private:
  Eigen::Matrix<double, 3, 4> setMotion(const StepReadings& readings, BodyMotion& motion) const;
  AxleMotion ackermannWithHub(const StepReadings& readings) const;
  void addCovariances(const StepReadings& readings, const Eigen::Matrix<double, 3, 4>& J,
                      BodyIncrement& increment) const;
  void setSensitivity(const StepReadings& readings, const Eigen::Matrix<double, 3, 4>& J,
                      BodyIncrement& increment) const;

  Vehicle vehicle_;
  NoiseModel noise_;
  OdometryOptions options_;
  Axle axle_;
};

}  // namespace bs_car_odometry
