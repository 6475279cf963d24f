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

  /// The message with one to three fields spoiled; one in fifty is cut as well, and one is too long.
  std::vector<std::uint8_t> spoil(std::vector<std::uint8_t> bytes);

 private:
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(random_.bits() % count); }
  std::uint64_t number();
  std::uint64_t integer();
  void spoilField(std::vector<std::uint8_t>& bytes);
  void flipBit(std::vector<std::uint8_t>& bytes);

  simulation::Random random_;
};

/// How many batches of so many spoiled messages a test sends that has this share of all of them:
/// $BS_CAR_ODOMETRY_FUZZED_MESSAGES, a hundred thousand when it is not set. Prints the number of messages.
int spoiledBatches(double share, int batch);

}  // namespace bs_car_odometry::testing
