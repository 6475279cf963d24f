#include "checks.hpp"
#include "wheel_order.hpp"

#include <array>
#include <cmath>
#include <string>

namespace bs_car_odometry::tools::doctor {

namespace {

constexpr std::size_t kFewestWindows = 6;
constexpr double kStill = 0.03;       ///< share of what was expected that still is standing
constexpr double kSameFactor = 1.05;  ///< between the factors of wheels that are wrong alike

std::string key(Wheel wheel) { return std::string("encoders/metres_per_tick/") + name(wheel); }

/// 1.97 is likelier a 2.
double rounded(double factor) {
  constexpr std::array<double, 8> kUsual{2.0, 3.0, 4.0, 10.0, 100.0, 1000.0, 2.0 * M_PI, 25.4};
  const double size = std::max(factor, 1.0 / factor);
  for (const double usual : kUsual)
    if (std::abs(size / usual - 1.0) < 0.06) return factor > 1.0 ? usual : 1.0 / usual;
  return factor;
}

std::vector<Wheel> usedWheels(const DriveRecord& record) {
  std::vector<Wheel> used;
  for (const Wheel wheel : kAllWheels)
    if (record.wheel_used[wheel]) used.push_back(wheel);
  return used;
}

std::string namesOf(const std::vector<Wheel>& wheels) {
  std::string text;
  for (std::size_t i = 0; i < wheels.size(); ++i)
    text += (i == 0 ? "" : i + 1 < wheels.size() ? ", " : " and ") + std::string(name(wheels[i]));
  return text;
}

/// What the car should have rolled, to tell a wheel that stands from a car that does.
double expectedPath(const DriveRecord& record, const std::vector<MotionWindow>& windows, Wheel wheel) {
  double path = 0.0;
  for (const MotionWindow& window : windows)
    path += std::abs(expectedTravel(record.configuration.vehicle, window.motion)[wheel]);
  return path;
}

Finding stillFinding(Wheel wheel, double rolled, double expected) {
  return error(
      format("%s stands still: it counts %.2f m where the car drove %.1f m", name(wheel), rolled, expected),
      std::string("check its encoder and cable, or take the wheel out with ") + key(wheel) + "=0");
}

Finding placesFinding(const WheelOrder& order, const char* source) {
  std::vector<Wheel> moved;
  std::string counters;
  for (std::size_t i = 0; i < order.wheels.size(); ++i) {
    if (order.place[i] == order.wheels[i]) continue;
    moved.push_back(order.wheels[i]);
    counters += std::string(counters.empty() ? "" : ", ") + name(order.wheels[i]) + " counts the " +
                name(order.place[i]) + " wheel";
  }
  if (moved.size() == 2)
    return error(namesOf(moved) + " are exchanged, by the " + source,
                 "exchange their connectors, or the fields that the driver fills");
  return error("the wheels are mixed up, by the " + std::string(source),
               counters + ": mend the wiring, or the fields that the driver fills");
}

Finding backwardsFinding(const DriveRecord& record, const std::vector<Wheel>& wheels, const char* source) {
  if (wheels.size() == usedWheels(record).size())
    return error(
        "every wheel counts backwards, by the " + std::string(source),
        "turn the signs of encoders/metres_per_tick, or laser/yaw by 3.14159 when the laser looks back");
  std::string remedy = "change the sign: ";
  for (const Wheel wheel : wheels)
    remedy += format("%s--set %s=%g", wheel == wheels.front() ? "" : " ", key(wheel).c_str(),
                     -record.parameters.vehicle.metres_per_tick[wheel]);
  return error(namesOf(wheels) + (wheels.size() == 1 ? " counts" : " count") + " backwards, by the " + source,
               remedy);
}

Finding sizeFinding(const DriveRecord& record, Wheel wheel, double factor) {
  const double size = std::abs(factor);
  const double zeta = std::abs(record.parameters.vehicle.metres_per_tick[wheel]) / rounded(size);
  return error(
      format("%s counts %.3g times the way that it rolled", name(wheel), size),
      format("check the wheel's radius and the ticks of a turn; %g would fit %s", zeta, key(wheel).c_str()));
}

Finding allSizesFinding(double factor) {
  return error(
      format("all wheels count %.3g times the way of the laser", factor),
      format("check radius, ticks of a turn and units: encoders/metres_per_tick divided by %.4g would fit",
             rounded(factor)));
}

/// True when every wheel is wrong by about the same factor.
bool wrongAlike(const WheelOrder& order) {
  double lowest = std::abs(order.factor[order.wheels.front()]);
  double highest = lowest;
  for (const Wheel wheel : order.wheels) {
    lowest = std::min(lowest, std::abs(order.factor[wheel]));
    highest = std::max(highest, std::abs(order.factor[wheel]));
  }
  return isGross(lowest) && isGross(highest) && highest < kSameFactor * lowest;
}

Findings factorFindings(const DriveRecord& record, const WheelOrder& order, const char* source) {
  Findings findings;
  std::vector<Wheel> backwards;
  for (const Wheel wheel : order.wheels)
    if (order.factor[wheel] < 0.0) backwards.push_back(wheel);
  if (!backwards.empty()) findings.push_back(backwardsFinding(record, backwards, source));
  if (wrongAlike(order)) {
    findings.push_back(allSizesFinding(std::abs(order.factor[order.wheels.front()])));
    return findings;
  }
  for (const Wheel wheel : order.wheels)
    if (isGross(order.factor[wheel])) findings.push_back(sizeFinding(record, wheel, order.factor[wheel]));
  return findings;
}

/// @param wheels  in: those that are used; out: those that turn
Findings findStillWheels(const DriveRecord& record, const std::vector<MotionWindow>& windows,
                         std::vector<Wheel>& wheels) {
  const PerWheel<WheelFactor> factors = wheelFactors(record.configuration.vehicle, windows);
  Findings findings;
  std::vector<Wheel> turning;
  for (const Wheel wheel : wheels) {
    const double expected = expectedPath(record, windows, wheel);
    if (factors[wheel].rolled < kStill * expected) {
      findings.push_back(stillFinding(wheel, factors[wheel].rolled, expected));
    } else {
      turning.push_back(wheel);
    }
  }
  wheels = turning;
  return findings;
}

}  // namespace

Findings checkWheels(const DriveRecord& record, const std::vector<MotionWindow>& windows,
                     const char* source) {
  std::vector<Wheel> wheels = usedWheels(record);
  if (windows.size() < kFewestWindows || wheels.empty())
    return {warning(format("the wheels could not be compared with the %s: %zu stretches of motion", source,
                           windows.size()),
                    "drive some ten metres with the localiser running")};
  Findings findings = findStillWheels(record, windows, wheels);
  if (wheels.empty()) return findings;
  const WheelOrder order = findWheelOrder(record.configuration.vehicle, windows, wheels);
  if (!order.isAsConfigured()) findings.push_back(placesFinding(order, source));
  append(factorFindings(record, order, source), findings);
  if (findings.empty())
    findings.push_back(fine(format("wheels: directions, places and sizes agree with the %s", source)));
  return findings;
}

}  // namespace bs_car_odometry::tools::doctor
