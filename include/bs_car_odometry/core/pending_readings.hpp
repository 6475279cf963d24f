#pragma once

#include "bs_car_odometry/core/body_increment.hpp"

namespace bs_car_odometry {

/// Readings of successive steps as those of one, to be compared with each other once they are long enough:
/// within the correlation length of the steering's error the fit would take them for better than they are,
/// and find a turn and residuals with the same noise (docs/calibration.md, C13).
class PendingReadings {
 public:
  void add(const StepReadings& readings);
  double length() const { return length_; }  ///< [m], mean over the wheels, without a sign
  /// True when a step goes the other way.
  bool isReversedBy(const StepReadings& readings) const;
  /// As of one step: travels added up, angles with their mean over the travel and their change.
  StepReadings readings() const;

 private:
  PerWheel<double> travel_;
  SteeringAngles begin_;
  SteeringAngles end_;
  SteeringAngles weighted_;  ///< [rad m], mean angles times lengths
  double length_{0.0};
};

}  // namespace bs_car_odometry
