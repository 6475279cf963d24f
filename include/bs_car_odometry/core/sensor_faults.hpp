#pragma once

#include "bs_car_odometry/core/wheels_and_axles.hpp"

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>

namespace bs_car_odometry {

/// The sensors that the fit compares, in the order of the rows of (W1): four wheels, then the angles of both
/// axles. With a rear law of the front angle the car has one sensor of steering, that of the front axle.
constexpr std::size_t kSensors = kWheels + kAxles;
using SensorSet = std::bitset<kSensors>;

constexpr std::size_t sensor(Wheel wheel) { return index(wheel); }
constexpr std::size_t sensor(Axle axle) { return kWheels + index(axle); }
constexpr bool isWheel(std::size_t sensor) { return sensor < kWheels; }

/// What is wrong with a sensor that is left out (docs/reliability.md, rows E7 to E9 and S6).
enum class SensorFault {
  kNone,
  kUndecided,    ///< one of several that contradict each other; which one is not known
  kStuck,        ///< the counter stands while the wheel turns
  kReversed,     ///< the counter runs backwards
  kWrongTravel,  ///< the wheel slips, or its metres per tick are wrong
  kSwapped,      ///< two wheels have each other's counters
  kWrongAngle,   ///< the steering sensor contradicts the wheels
  kFrozen,       ///< the same speed is read again and again while the wheel's changes
};

struct SensorState {
  SensorFault fault{SensorFault::kNone};
  double ratio{1.0};        ///< of a wheel's measured travel to that of the other sensors
  double angle_error{0.0};  ///< [rad] of an angle against the other sensors
  double duration{0.0};     ///< [s] for which it has been left out
};

struct SensorReport {
  std::array<SensorState, kSensors> sensors;
  bool determined{true};        ///< false: something contradicts, and the rest is not enough to do without it
  std::uint64_t exclusions{0};  ///< how often something was left out

  const SensorState& operator[](Wheel wheel) const { return sensors[sensor(wheel)]; }
  const SensorState& operator[](Axle axle) const { return sensors[sensor(axle)]; }
};

}  // namespace bs_car_odometry
