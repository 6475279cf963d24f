#pragma once

#include "bs_car_odometry/CalibrationState.h"
#include "bs_car_odometry/calibration/result.hpp"
#include "bs_car_odometry/core/odometry_configuration.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace bs_car_odometry {

/// What the odometry takes of a calibration that runs beside it: the values that are observed and move the
/// car, with their covariance (docs/calibration.md, 7). Other parameters stay as they are in use.
class CalibrationAcceptance {
 public:
  struct Answer {
    std::string refused;  ///< why nothing of the message is used; empty if it may be
    std::optional<OdometryCalibration> calibration;  ///< to be used from now on; none where nothing is new
  };

  explicit CalibrationAcceptance(const Parameters& parameters);

  /// @param in_use  what the odometry uses at present
  Answer take(const CalibrationState& message, const OdometryCalibration& in_use);

  /// How often something new was taken.
  std::uint64_t taken() const { return taken_; }

 private:
  bool isNews(const calibration::CalibrationResult& result) const;
  OdometryCalibration merged(const calibration::CalibrationResult& result, const OdometryCalibration& in_use);

  Parameters parameters_;
  std::uint32_t vehicle_checksum_;
  calibration::CalibrationResult newest_;  ///< taken so far
  std::uint64_t taken_{0};
};

}  // namespace bs_car_odometry
