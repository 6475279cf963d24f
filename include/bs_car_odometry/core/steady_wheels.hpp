#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/vehicle.hpp"

namespace bs_car_odometry {

/// For how long each wheel's speed has stayed the same to a tick. That of a wheel that turns never does for
/// long; that of a silent sensor does, whose driver repeats the last one.
class SteadyWheels {
 public:
  /// Successive stretches in which a wheel's speed was the same.
  struct Run {
    StepReadings first;   ///< of its first stretch
    double seconds{0.0};  ///< duration of that
    int stretches{0};
  };

  explicit SteadyWheels(const Vehicle& vehicle);

  /// Nothing has been read yet.
  void reset() { runs_ = PerWheel<Run>(); }
  /// @param stretch  readings of about a tenth of a second, and how long they took
  void add(const StepReadings& stretch, double seconds);
  const Run& run(Wheel wheel) const { return runs_[wheel]; }

  /// [m/s] by which a wheel's speed must change at least before it counts as changed.
  double leastChange(Wheel wheel, const StepReadings& stretch, double seconds) const;
  /// True when the wheel's speed has been the same for a second, and every other wheel with an encoder has
  /// another one than when that began.
  /// @param ignored  wheels of which nothing is asked
  bool isLeftBehind(Wheel wheel, const StepReadings& stretch, double seconds,
                    const PerWheel<bool>& ignored) const;

 private:
  bool departs(const Run& run, Wheel wheel, const StepReadings& stretch, double seconds) const;

  PerWheel<double> tick_;  ///< [m], 0 without an encoder
  PerWheel<Run> runs_;
};

}  // namespace bs_car_odometry
