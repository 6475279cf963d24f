#include "bs_car_odometry/ros/fault_sentences.hpp"

#include <array>
#include <cmath>
#include <cstdio>

namespace bs_car_odometry {

namespace {

using Level = diagnostic_msgs::DiagnosticStatus;

constexpr double kSlip = 3.0;  // [s], as long as a wheel may slip before its encoder or gain is suspected

std::string nameOf(std::size_t sensor) {
  if (!isWheel(sensor)) return std::string(name(static_cast<Axle>(sensor - kWheels))) + " steering";
  std::string wheel = name(static_cast<Wheel>(sensor));
  wheel[wheel.find('_')] = ' ';
  return wheel + " wheel";
}

std::string format(const char* text, double value) {
  std::array<char, 96> buffer{};
  std::snprintf(buffer.data(), buffer.size(), text, value);
  return buffer.data();
}

std::string wrongTravel(const SensorState& state) {
  const double percent = 100.0 * (state.ratio - 1.0);
  const std::string travel =
      format(percent > 0.0 ? "turns %.0f %% too far" : "turns %.0f %% too little", std::abs(percent));
  if (state.duration < kSlip) return travel + ": it slips";
  return travel + ": does it slip all the time, or is its metres_per_tick wrong? Calibrate";
}

std::string fault(const SensorState& state) {
  switch (state.fault) {
    case SensorFault::kNone:
      return "";
    case SensorFault::kUndecided:
      return "contradicts others, and which of them is wrong is not known: drive on, with turns";
    case SensorFault::kStuck:
      return "does not count: check its encoder and cable";
    case SensorFault::kReversed:
      return "counts backwards: change the sign of its metres_per_tick, or its wiring";
    case SensorFault::kWrongTravel:
      return wrongTravel(state);
    case SensorFault::kSwapped:
      return "has the counter of another: change their wires, or their order in the driver";
    case SensorFault::kWrongAngle:
      return format("is %.2f rad off the wheels: check its sensor, steering/scale and offset",
                    std::abs(state.angle_error));
    case SensorFault::kFrozen:
      return "says the same speed again and again while it changes: check its sensor and what its driver "
             "repeats";
  }
  return "";
}

}  // namespace

std::string explain(std::size_t sensor, const SensorState& state) {
  return state.fault == SensorFault::kNone ? "" : nameOf(sensor) + " left out, it " + fault(state);
}

std::string explain(const SensorReport& report) {
  std::string all;
  for (std::size_t i = 0; i < kSensors; ++i) {
    const std::string one = explain(i, report.sensors[i]);
    if (!all.empty() && !one.empty()) all += "; ";
    all += one;
  }
  return all;
}

unsigned char level(const SensorState& state) {
  if (state.fault == SensorFault::kNone) return Level::OK;
  const bool slips = state.fault == SensorFault::kWrongTravel || state.fault == SensorFault::kUndecided;
  return slips && state.duration < kSlip ? Level::WARN : Level::ERROR;
}

std::string explainUndetermined(const SensorReport& report) {
  return report.determined
             ? ""
             : "the sensors contradict each other, and too few are left to do without the wrong "
               "one: do not trust the odometry, check encoders and steering, then call ~reset";
}

}  // namespace bs_car_odometry
