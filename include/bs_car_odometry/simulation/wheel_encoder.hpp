#pragma once

#include "bs_car_odometry/simulation/random.hpp"

#include <cstdint>

namespace bs_car_odometry::simulation {

/// Counter of one wheel: true travel plus noise that is white in distance, rounded from the running sum,
/// wrapped.
class WheelEncoder {
 public:
  struct Settings {
    double metres_per_tick{0.0};  ///< in truth (with the gain) [m]; 0: no encoder, the counter stays
    Distribution noise{0.0};  ///< c [m/sqrt(m)]: a draw times sqrt|S|, S the travel since the last reading
    int counter_bits{32};     ///< two's complement of so many bits; 0: never wraps
    std::int64_t start{0};    ///< counter at the start
  };

  WheelEncoder(const Settings& settings, Random random) : settings_(settings), random_(random) {}

  /// @param travel of the wheel since the start [m]
  std::int64_t read(double travel);

  /// Travel as measured at the last reading, before it is rounded [m].
  double measuredTravel() const { return travel_ + noise_; }

 private:
  Settings settings_;
  Random random_;
  double travel_{0.0};
  double noise_{0.0};
};

/// The low `bits` bits of a counter as a signed number; all of it for 0 or 64.
std::int64_t wrapCounter(std::int64_t counter, int bits);

}  // namespace bs_car_odometry::simulation
