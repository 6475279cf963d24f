#pragma once

#include "bs_car_odometry/core/wheels_and_axles.hpp"

#include <string>
#include <vector>

namespace bs_car_odometry {

/// How the two wheels of one axle point when the axle's angle is alpha (docs/model.md, section 3).
enum class AxleGeometry {
  kAckermann,  ///< each wheel rolls along its own velocity: the axes meet in the turning centre (model B)
  kPivot,      ///< parallel wheels, both at alpha, each on its own kingpin (model A, the paper's)
};

/// phi_rear = f(phi_front) as a polynomial, or measured by a sensor of its own.
struct RearSteering {
  enum class Source { kPolynomial, kMeasured };
  Source source{Source::kPolynomial};
  std::vector<double> coefficients{0.0,
                                   -1.0};  ///< of f, ascending powers [rad]; Cycab: phi_rear = -phi_front

  /// f(phi_front) [rad].
  double angle(double phi_front) const {
    double f = 0.0;
    for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) f = f * phi_front + *c;
    return f;
  }

  /// f'(phi_front).
  double slope(double phi_front) const {
    double f = 0.0;
    double slope = 0.0;
    for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) {
      slope = slope * phi_front + f;
      f = f * phi_front + *c;
    }
    return slope;
  }

  /// True when f does not depend on the front angle.
  bool isConstant() const {
    for (std::size_t i = 1; i < coefficients.size(); ++i)
      if (coefficients[i] != 0.0) return false;
    return true;
  }
};

/// Gains of one axle: truth / nominal, 1 for a perfect car (docs/model.md, (9)).
struct AxleGains {
  double k_r{1.0};  ///< travel of the right wheel
  double k_l{1.0};  ///< travel of the left wheel
  double k_b{1.0};  ///< track
};

/// angle = scale * reading + offset.
struct SteeringCalibration {
  double scale{1.0};
  double offset{0.0};  ///< [rad]
};

/// The car: its nominal geometry and what a calibration adds to it. One struct serves every drivetrain:
/// two steered axles, an ordinary car (f = 0), a differential robot (one axle at alpha = 0).
/// Frame: `base_link` on the car's axis, x forward, y left; angles counter-clockwise.
struct Vehicle {
  std::string name;            ///< a calibration is refused on a car of another name
  double wheelbase{0.0};       ///< L [m], middle of the front axle to middle of the rear axle
  PerAxle<double> track;       ///< B [m], between the tyre contact points with the wheels straight
  double base_link_x{0.0};     ///< [m], base_link ahead of the middle of the rear axle
  PerAxle<double> hub_offset;  ///< h [m], kingpin to contact point along the wheel's axle, outward positive
  AxleGeometry axle_geometry{AxleGeometry::kAckermann};
  RearSteering rear_steering;
  PerWheel<double> metres_per_tick;  ///< zeta [m], negative: mounted backwards, 0: no encoder on this wheel
  int counter_bits{32};              ///< counters wrap modulo 2^bits; 0: never

  PerAxle<AxleGains> gains;
  PerAxle<SteeringCalibration> steering;

  /// Position of the axle along x in base_link [m]: a_f, a_r.
  double axleX(Axle axle) const { return axle == Axle::kFront ? wheelbase - base_link_x : -base_link_x; }

  /// Track with its gain [m]: k_b B.
  double calibratedTrack(Axle axle) const { return gains[axle].k_b * track[axle]; }

  /// Gain of the wheel's travel: k_l or k_r of its axle.
  double wheelGain(Wheel wheel) const {
    const AxleGains& axle_gains = gains[axleOf(wheel)];
    return isLeft(wheel) ? axle_gains.k_l : axle_gains.k_r;
  }

  /// Metres per tick with the gain: k zeta.
  double calibratedMetresPerTick(Wheel wheel) const { return wheelGain(wheel) * metres_per_tick[wheel]; }

  bool hasEncoder(Wheel wheel) const { return metres_per_tick[wheel] != 0.0; }
};

}  // namespace bs_car_odometry
