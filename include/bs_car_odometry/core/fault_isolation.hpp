#pragma once

#include "bs_car_odometry/core/sensor_faults.hpp"
#include "bs_car_odometry/core/wheel_fit.hpp"

#include <array>
#include <limits>

namespace bs_car_odometry {

/// The hypothesis that one sensor is wrong by a constant: a wheel by a part of its travel, an angle by an
/// offset (docs/model.md, (F2)).
struct SensorTest {
  double deviation{0.0};  ///< estimate of that constant beyond what p(A) allows: [1] or [rad]
  double sigma{std::numeric_limits<double>::infinity()};  ///< its standard deviation
  double fall{0.0};  ///< of chi-square, if the sensor is wrong; chi-square (1) of a sound one
};

/// What readings say of every sensor.
struct SensorTests {
  double chi_square{0.0};  ///< of the readings, p(A) allowed for (F1)
  std::array<SensorTest, kSensors> sensors;
};

/// Tests readings of which one sensor may be wrong, or a sum of such evidence over successive ones.
/// @param prior  p(A): errors of the parameters within it are no fault
SensorTests testSensors(const ParameterEvidence& evidence, const SystematicCovariance& prior);

/// The sensors of which one is wrong, the likeliest first; empty when nothing is, or nothing explains it.
struct Suspects {
  std::array<std::size_t, kSensors> sensors{};
  std::size_t count{0};
};
/// @param length  that the readings are of [m]
Suspects suspects(const SensorTests& tests, double length);

/// A deviation below this is no fault whatever its significance: cars depart so far from their models.
double leastFault(std::size_t sensor);

}  // namespace bs_car_odometry
