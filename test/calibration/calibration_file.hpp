#pragma once

#include "bs_car_odometry/calibration/result_file.hpp"

#include <boost/crc.hpp>

#include <cstdio>
#include <string>

namespace bs_car_odometry::calibration::testing {

/// The car of docs/interface.md.
inline Parameters cycab() {
  Parameters parameters;
  parameters.vehicle.name = "cycab";
  parameters.vehicle.wheelbase = 1.2;
  parameters.vehicle.track = {1.2, 1.2};
  parameters.vehicle.metres_per_tick.values.fill(1e-4);
  parameters.odometry.axles = AxleSelection::kRear;
  return parameters;
}

/// Numbers that no short text says, of gains, steering offset and scale, and laser mount.
inline CalibrationResult result() {
  CalibrationResult result;
  const std::size_t listed[] = {systematic::kRearRight,   systematic::kRearLeft, systematic::kRearTrack,
                                systematic::kFrontOffset, kFrontScale,           kLaserX};
  double number = 1.0;
  for (const std::size_t i : listed) {
    result.listed[i] = true;
    number += 1.0 / 300.0;
    result.values[static_cast<Eigen::Index>(i)] = number;
  }
  // B B^T of anything is positive semidefinite.
  ParameterMatrix B = ParameterMatrix::Zero();
  for (const std::size_t i : listed)
    for (const std::size_t j : listed) {
      number = 3.7 * number * (1.0 - number / 9.0);  // to and fro between 0 and 9, without a pattern
      B(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = 1e-4 * number;
    }
  result.covariance = B * B.transpose();
  result.covariance = (0.5 * (result.covariance + result.covariance.transpose())).eval();
  result.not_observed[kLaserY] = true;
  result.data = {
      {"morning.bag", "it's a \"bag\" [of] {mine} & yours.bag"}, 1767225600.0, 1767226255.2, 412.6, 6540, 12};
  return result;
}

/// The text with the checksum that its other lines have.
inline std::string withChecksum(const std::string& lines) {
  boost::crc_32_type crc;
  crc.process_bytes(lines.data(), lines.size());
  char line[32];
  std::snprintf(line, sizeof line, "checksum: %08x\n", static_cast<unsigned>(crc.checksum()));
  return lines + line;
}

/// The text without its last line.
inline std::string withoutChecksum(const std::string& text) {
  return text.substr(0, text.rfind("checksum: "));
}

/// Why the text is refused; empty when it is not.
inline std::string refusal(const std::string& text, const Parameters& parameters = cycab()) {
  try {
    fromText(text, parameters);
  } catch (const CalibrationFileError& error) {
    return error.what();
  }
  return "";
}

}  // namespace bs_car_odometry::calibration::testing
