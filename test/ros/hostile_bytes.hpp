#pragma once

#include "bs_car_odometry/simulation/random.hpp"

#include <cstdint>
#include <vector>

namespace bs_car_odometry::testing {

/// Spoils the bytes of good messages: any field gets any value, and lengths lie. The same seed spoils the
/// same way.
class HostileBytes {
 public:
  explicit HostileBytes(std::uint64_t seed) : random_(seed, 0) {}

  /// The message with one to three fields spoiled, one in fifty cut as well.
  std::vector<std::uint8_t> spoil(std::vector<std::uint8_t> bytes);

 private:
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(random_.bits() % count); }
  std::uint64_t number();
  std::uint64_t integer();
  void spoilField(std::vector<std::uint8_t>& bytes);

  simulation::Random random_;
};

}  // namespace bs_car_odometry::testing
