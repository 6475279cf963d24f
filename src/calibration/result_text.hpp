#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

/// What writing and reading of a calibration file have in common.
namespace bs_car_odometry::calibration {

constexpr const char* kChecksumKey = "checksum: ";

/// A line that ends a file: "checksum: 5d0c2f1a" and a line break.
std::string checksumLine(const char* text, std::size_t size);

/// As zlib's.
std::uint32_t crc32(const char* text, std::size_t size);

/// Where the value of a parameter stands: front/k_r in gains, front, k_r.
struct Place {
  std::string group;  ///< gains, steering or laser
  std::string axle;   ///< front, rear; empty for the laser
  std::string key;    ///< k_r, offset, x, ...
};

Place placeOf(std::size_t parameter);

}  // namespace bs_car_odometry::calibration
