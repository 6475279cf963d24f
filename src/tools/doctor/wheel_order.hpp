#pragma once

#include "motion_windows.hpp"

#include "bs_car_odometry/core/vehicle.hpp"

#include <vector>

namespace bs_car_odometry::tools::doctor {

/// What the body's motion asks of each wheel in a window [m]: the way of its contact point, negative
/// backwards. The wheel rolls along its own velocity (K3), so that no angle is needed.
PerWheel<double> expectedTravel(const Vehicle& vehicle, const BodyMotion& motion);

/// A wheel's readings set beside what the motion asks of the place it is configured for.
struct WheelFactor {
  double factor{1.0};  ///< measured / expected, by least squares
  double rolled{0.0};  ///< [m] sum of measured travels without their signs
};

PerWheel<WheelFactor> wheelFactors(const Vehicle& vehicle, const std::vector<MotionWindow>& windows);

/// Where the counters really come from: `place[i]` is the wheel that the readings of wheels[i] fit best.
struct WheelOrder {
  std::vector<Wheel> wheels;
  std::vector<Wheel> place;
  PerWheel<double> factor;  ///< measured / expected at that place

  bool isAsConfigured() const { return wheels == place; }
};

/// Tries every order of `wheels` (at least two) over the windows. An order other than the configured one must
/// be far likelier, so that wheels which always roll alike, as those of one side when phi_rear = -phi_front,
/// and a drive without turns leave the configured one.
WheelOrder findWheelOrder(const Vehicle& vehicle, const std::vector<MotionWindow>& windows,
                          const std::vector<Wheel>& wheels);

/// A factor that no tyre explains.
bool isGross(double factor);

}  // namespace bs_car_odometry::tools::doctor
