#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/pending_readings.hpp"
#include "bs_car_odometry/core/vehicle.hpp"

namespace bs_car_odometry {

/// For how long each wheel's speed has stayed the same, as far as a counter can tell. That of a silent sensor
/// does, whose driver repeats the last one, while those of the others change.
class SteadyWheels {
 public:
  /// Successive stretches in which a wheel's speed was the same.
  struct Run {
    StepReadings first;   ///< of its first stretch
    double seconds{0.0};  ///< duration of that
    int stretches{0};
    PendingReadings all;  ///< their readings
  };

  explicit SteadyWheels(const Vehicle& vehicle);

  /// Nothing has been read yet.
  void reset() { runs_ = PerWheel<Run>(); }
  /// Other gains: runs go on, but what was read by the old ones is forgotten.
  void setVehicle(const Vehicle& vehicle);
  /// @param stretch  readings of about a tenth of a second, and how long they took
  void add(const StepReadings& stretch, double seconds);
  const Run& run(Wheel wheel) const { return runs_[wheel]; }

  /// [m/s] by which a wheel's speed must differ at least from that at the beginning of another's run before
  /// it counts as changed.
  double leastChange(Wheel wheel, const StepReadings& stretch, double seconds) const;
  /// True when every other wheel with an encoder has changed its speed since this one's run began.
  /// @param ignored  wheels of which nothing is asked
  bool isLeftBehind(Wheel wheel, const StepReadings& stretch, double seconds,
                    const PerWheel<bool>& ignored) const;

 private:
  bool departs(const Run& run, Wheel wheel, const StepReadings& stretch, double seconds) const;

  PerWheel<double> tick_;  ///< [m], 0 without an encoder
  PerWheel<Run> runs_;
};

}  // namespace bs_car_odometry
