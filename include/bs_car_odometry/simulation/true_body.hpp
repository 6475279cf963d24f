#pragma once

#include "bs_car_odometry/core/vehicle.hpp"
#include "bs_car_odometry/simulation/scenario.hpp"
#include "bs_car_odometry/simulation/true_parameters.hpp"

namespace bs_car_odometry::simulation {

/// Of base_link in odom; yaw is not wrapped.
struct Pose {
  double x{0.0};    ///< [m]
  double y{0.0};    ///< [m]
  double yaw{0.0};  ///< [rad]
};

/// Of base_link, in base_link.
struct Twist {
  double vx{0.0};        ///< [m/s]
  double vy{0.0};        ///< [m/s]
  double yaw_rate{0.0};  ///< [rad/s]
};

/// Unit vector in base_link: (cos, sin) of an angle.
struct Direction {
  double cos{1.0};
  double sin{0.0};
};

/// Angles, wheel directions and speed of the car at one instant.
struct Instant {
  double speed{0.0};          ///< V [m/s]
  double yaw_rate{0.0};       ///< of the command [rad/s], differential robots only
  PerAxle<Direction> axle;    ///< along phi_f, phi_r
  PerWheel<Direction> wheel;  ///< along which each wheel rolls
};

/// The rigid car: where its axles and kingpins are, and how it moves when its wheels roll without side slip.
class TrueBody {
 public:
  TrueBody(const Vehicle& vehicle, const TrueParameters& truth, Drivetrain drivetrain);

  /// @param law_error departure of phi_r from f(phi_f) [rad]
  Instant instant(const Command& command, double law_error) const;

  /// Twist from no side slip of the axle middles but `slip` (K1), solved from the rear axle on:
  ///   v_R = V (cos phi_r, sin phi_r) + n_r (-sin phi_r, cos phi_r)
  ///   -sin(phi_f) vx + cos(phi_f) v_Fy = n_f ,   omega = (v_Fy - v_Ry) / L
  /// @param slip sideways velocities n_f, n_r of the axle middles [m/s], to the left of the axle's angle
  Twist twist(const Instant& instant, const PerAxle<double>& slip = {}) const;

  /// Speed of the kingpin along the wheel's rolling direction [m/s]; the hub offset is not in it.
  double rollingSpeed(Wheel wheel, const Instant& instant, const Twist& twist) const;

  /// (|s_r| + |s_l|)/2 of the axle's wheels [m/s], for parallel wheels; turning on the spot also counts.
  double axleTravelRate(Axle axle, const Instant& instant, const Twist& twist) const;

  /// What the wheel rolls for each radian that its carrier turns [m]: -h on the left, +h on the right.
  double hubArm(Wheel wheel) const { return hub_arm_[wheel]; }

 private:
  PerWheel<Direction> wheelDirections(const Instant& instant) const;

  RearSteering rear_steering_;
  AxleGeometry axle_geometry_;
  Drivetrain drivetrain_;
  double wheelbase_;
  PerAxle<double> axle_x_;
  PerAxle<double> half_track_;
  PerWheel<double> kingpin_x_;
  PerWheel<double> kingpin_y_;
  PerWheel<double> hub_arm_;
};

}  // namespace bs_car_odometry::simulation
