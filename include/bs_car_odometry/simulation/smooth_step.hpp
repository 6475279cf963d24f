#pragma once

namespace bs_car_odometry::simulation {

/// s(t; begin, end) = u^2 (3 - 2u), u = clamp((t - begin) / (end - begin), 0, 1).
inline double smoothStep(double t, double begin, double end) {
  if (t <= begin) return 0.0;
  if (t >= end) return 1.0;
  const double u = (t - begin) / (end - begin);
  return u * u * (3.0 - 2.0 * u);
}

/// Up to 1 in the first `ramp`, down to 0 in the last; the area below it is total - ramp.
inline double smoothPulse(double t, double ramp, double total) {
  return smoothStep(t, 0.0, ramp) - smoothStep(t, total - ramp, total);
}

}  // namespace bs_car_odometry::simulation
