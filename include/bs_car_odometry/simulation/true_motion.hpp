#pragma once

#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/simulation/correlated_error.hpp"
#include "bs_car_odometry/simulation/random.hpp"
#include "bs_car_odometry/simulation/scenario.hpp"
#include "bs_car_odometry/simulation/true_body.hpp"

#include <cstdint>

namespace bs_car_odometry::simulation {

/// The motion of the car in truth: pose of base_link, and what every wheel rolls.
///
/// The twist depends on time alone, not on the pose, so each substep is a quadrature: Simpson's rule for
/// heading, path and wheels (fourth order). Side slip and the error of the rear law are constant within a
/// substep and belong to fixed substeps of the clock, so the truth does not depend on when the sensors are
/// read.
class TrueMotion {
 public:
  struct Noise {
    Distribution lateral{0.0};       ///< [m/sqrt(m)], side slip of each axle
    Distribution rear_law{0.0};      ///< [rad]
    double correlation_length{0.1};  ///< [m], of the rear law's error
  };

  /// @param substep [s]
  TrueMotion(const TrueBody& body, Scenario scenario, const Noise& noise, std::uint64_t seed, double substep,
             const Pose& initial_pose);

  /// Moves on to `time` [s since the start]; @throws std::invalid_argument when that lies in the past.
  void advanceTo(double time);

  double time() const { return time_; }
  const Pose& pose() const { return pose_; }

  /// Without the white side slip, which has no value at an instant.
  Twist twist() const { return body_.twist(now_); }

  /// True angle of the axle [rad].
  double angle(Axle axle) const;

  /// What the wheel has rolled since the start [m], forward positive: its kingpin's way along the rolling
  /// direction, the turning of its carrier on the hub offset (H), and spinning.
  double travel(Wheel wheel) const;

  /// Travel of the kingpins alone [m].
  double kingpinTravel(Wheel wheel) const { return kingpin_travel_[wheel]; }

 private:
  void startSubstep();
  void integrateTo(double time);
  double carrierAngle(Wheel wheel) const;

  TrueBody body_;
  Scenario scenario_;
  Noise noise_;
  double substep_;
  Random slip_random_;
  CorrelatedError law_error_;

  double time_{0.0};
  std::int64_t substeps_done_{0};
  double rear_travel_{0.0};  ///< [m] in the present substep
  PerAxle<double> slip_;     ///< n_f, n_r of the present substep [m/s]
  Instant now_;
  Pose pose_;
  Direction heading_;
  PerWheel<double> kingpin_travel_;
  PerWheel<double> carrier_start_;  ///< [rad]
};

}  // namespace bs_car_odometry::simulation
