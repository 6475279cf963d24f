#pragma once

#include "bs_car_odometry/ros/raw_message.hpp"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

namespace bs_car_odometry::fuzz {

/// What libFuzzer gives a target, taken value by value; zeros once it is used up.
class Bytes : public ByteReader {
 public:
  explicit Bytes(const std::vector<std::uint8_t>& bytes) : ByteReader(bytes) {}

  std::size_t below(std::size_t count) { return value<std::uint8_t>() % count; }
  bool flag() { return below(2) != 0; }

  /// Any number, and often one of those that a search finds late.
  double number() {
    using Limits = std::numeric_limits<double>;
    constexpr double kRare[] = {Limits::quiet_NaN(),  Limits::infinity(), -Limits::infinity(), -0.0,
                                Limits::denorm_min(), Limits::max()};
    const std::size_t i = below(4 * std::size(kRare));
    return i < std::size(kRare) ? kRare[i] : value<double>();
  }
};

inline std::string textOf(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Ends the run: libFuzzer keeps the input that did it.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

}  // namespace bs_car_odometry::fuzz
