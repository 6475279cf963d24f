#pragma once

#include "bs_car_odometry/core/sensor_faults.hpp"

#include <diagnostic_msgs/DiagnosticStatus.h>

#include <string>

namespace bs_car_odometry {

/// What is wrong with a sensor that is left out, and what to do about it; empty for a sound one.
std::string explain(std::size_t sensor, const SensorState& state);

/// The same for all of them, in one line.
std::string explain(const SensorReport& report);

/// Level of /diagnostics: WARN for a wheel that slips for a moment, ERROR for what stays.
unsigned char level(const SensorState& state);

/// Where the motion is not known without what contradicts; empty elsewhere.
std::string explainUndetermined(const SensorReport& report);

}  // namespace bs_car_odometry
