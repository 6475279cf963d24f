#include "hostile_bytes.hpp"

#include "support/environment.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <iterator>
#include <limits>
#include <string>

namespace bs_car_odometry::testing {

/// Bits of a double: bad and extreme ones, powers of two of any size, random bits.
std::uint64_t HostileBytes::number() {
  using Limits = std::numeric_limits<double>;
  const double special[] = {
      Limits::quiet_NaN(), Limits::infinity(), Limits::max(), Limits::min(), 5e-324, 0.0, 1.0, 1e19, 1e150,
      M_PI / 2.0,          1.3000001};
  double value = special[below(std::size(special))];
  const std::size_t kind = below(3);
  if (kind == 1) value = std::ldexp(1.0, static_cast<int>(below(2098)) - 1074);
  std::uint64_t bits = random_.bits();
  if (kind == 2) return bits;
  if (below(2) == 0) value = -value;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

/// Counters, stamps and lengths: powers of two with their neighbours, extremes, random bits.
std::uint64_t HostileBytes::integer() {
  const std::size_t kind = below(4);
  if (kind == 0) return random_.bits();
  if (kind == 1) return ~std::uint64_t{0} >> below(64);
  const std::uint64_t power = std::uint64_t{1} << below(64);
  return kind == 2 ? power : std::uint64_t{0} - power - below(2);
}

/// Most fields of ROS messages lie at multiples of four bytes; what comes after a text of another length, or
/// after single bytes, does not.
void HostileBytes::spoilField(std::vector<std::uint8_t>& bytes) {
  constexpr std::size_t kSizes[] = {1, 4, 8, 8};
  if (bytes.empty()) return;
  std::size_t at = below(bytes.size());
  if (below(4) != 0) at -= at % 4;
  const std::uint64_t value = below(2) == 0 ? number() : integer();
  const std::size_t size = std::min(kSizes[below(std::size(kSizes))], bytes.size() - at);
  std::memcpy(bytes.data() + at, &value, size);
}

void HostileBytes::flipBit(std::vector<std::uint8_t>& bytes) {
  if (bytes.empty()) return;
  bytes[below(bytes.size())] ^= static_cast<std::uint8_t>(1u << below(8));
}

std::vector<std::uint8_t> HostileBytes::spoil(std::vector<std::uint8_t> bytes) {
  for (std::size_t fields = 1 + below(3); fields > 0; --fields) {
    if (below(4) == 0) {
      flipBit(bytes);
    } else {
      spoilField(bytes);
    }
  }
  const std::size_t length = below(50);
  if (length == 0) bytes.resize(below(bytes.size() + 1));
  if (length == 1) bytes.resize(bytes.size() + below(100), static_cast<std::uint8_t>(random_.bits()));
  return bytes;
}

int spoiledBatches(double share, int batch) {
  const double messages = share * fromEnvironment("BS_CAR_ODOMETRY_FUZZED_MESSAGES", 100000.0);
  const int batches = static_cast<int>(std::ceil(messages / batch));
  std::cout << batches * batch << " spoiled messages" << std::endl;
  return batches;
}

}  // namespace bs_car_odometry::testing
