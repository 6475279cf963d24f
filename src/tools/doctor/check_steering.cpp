#include "checks.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace bs_car_odometry::tools::doctor {

namespace {

constexpr double kDegrees = 180.0 / M_PI;
constexpr double kNearlyThat = 1.4;   ///< a factor within this of 57.3 comes from degrees
constexpr double kWrongScale = 1.35;  ///< beyond this a sensor's ratio is wrong; steering boxes vary below
constexpr std::size_t kFewestWindows = 6;
constexpr double kConstant = 0.01;     // [rad], range of a dead sensor
constexpr double kSteered = 0.05;      // [rad], standard deviation of an angle that moved
constexpr double kSignificant = 5.0;   // sigma
constexpr double kLargest = 1.5;       // [rad]
constexpr double kManyBeyond = 0.001;  ///< share of readings beyond the limit that noise does not explain

/// A line through (reading, angle by the laser).
struct Line {
  double slope{0.0};
  double slope_sigma{0.0};
  double angle_spread{0.0};    ///< [rad] standard deviation of the angle by the laser
  double reading_spread{0.0};  ///< [rad]
};

Line fit(const std::vector<double>& readings, const std::vector<double>& angles) {
  const double n = static_cast<double>(readings.size());
  double mean_r = 0.0, mean_a = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    mean_r += readings[i] / n;
    mean_a += angles[i] / n;
  }
  double rr = 1e-12, ra = 0.0, aa = 0.0;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    rr += (readings[i] - mean_r) * (readings[i] - mean_r);
    ra += (readings[i] - mean_r) * (angles[i] - mean_a);
    aa += (angles[i] - mean_a) * (angles[i] - mean_a);
  }
  const double left = std::max(aa - ra * ra / rr, 1e-6 * n);
  return {ra / rr, std::sqrt(left / (n - 2.0) / rr), std::sqrt(aa / n), std::sqrt(rr / n)};
}

/// Angle of the front axle at which the car turns with `curvature` when the rear axle keeps its law, by
/// bisection. Meaningless where the law lets the curvature fall.
double frontAngleFor(const Vehicle& vehicle, double curvature) {
  double low = -kLargest;
  double high = kLargest;
  for (int i = 0; i < 40; ++i) {
    const double mid = 0.5 * (low + high);
    const double rear = vehicle.rear_steering.angle(mid);
    const double at =
        std::abs(rear) < kLargest ? pathShape(vehicle, {mid, rear}).curvature : std::copysign(1e9, mid);
    (at < curvature ? low : high) = mid;
  }
  return 0.5 * (low + high);
}

bool lawTurns(const Vehicle& vehicle) {
  constexpr double kProbe = 0.05;
  const auto at = [&](double phi) {
    return pathShape(vehicle, {phi, vehicle.rear_steering.angle(phi)}).curvature * vehicle.wheelbase;
  };
  return at(kProbe) - at(-kProbe) > kProbe;
}

/// Angle of an axle by the laser: what the curvature asks for, or the direction in which the axle moves.
double angleByLaser(const Vehicle& vehicle, Axle axle, const BodyMotion& motion) {
  const double way = std::copysign(motion.head<2>().norm(), motion.x());
  if (vehicle.rear_steering.source == RearSteering::Source::kPolynomial)
    return frontAngleFor(vehicle, motion.z() / (std::abs(motion.x()) > 1e-6 ? motion.x() : way));
  return std::atan((motion.y() + motion.z() * vehicle.axleX(axle)) / motion.x());
}

std::string key(Axle axle) { return std::string("steering/") + name(axle) + "/scale"; }

Finding scaleFinding(const DriveRecord& record, Axle axle, const Line& line) {
  const double size = std::abs(line.slope);
  const double configured = record.configuration.vehicle.steering[axle].scale;
  const auto near = [size](double factor) {
    return size > factor / kNearlyThat && size < factor * kNearlyThat;
  };
  if (near(1.0 / kDegrees))
    return error(format("%s_steering is in degrees: by the laser the angles are %.4f of the readings",
                        name(axle), size),
                 format("publish radians, or --set %s=%.6g", key(axle).c_str(), configured / kDegrees));
  if (near(kDegrees))
    return error(format("%s_steering was turned from degrees to radians twice: by the laser the angles are "
                        "%.1f times the readings",
                        name(axle), size),
                 format("publish radians, or --set %s=%.6g", key(axle).c_str(), configured * kDegrees));
  return warning(format("%s_steering: by the laser the angles are %.2f +/- %.2f times the readings",
                        name(axle), size, line.slope_sigma),
                 format("check the steering ratio: --set %s=%.3g would fit; or estimate steering_scale",
                        key(axle).c_str(), configured * size));
}

bool isWrongScale(const Line& line) {
  const double size = std::abs(line.slope);
  const double doubt = kSignificant * line.slope_sigma;
  return size > doubt && (size - doubt > kWrongScale || size + doubt < 1.0 / kWrongScale);
}

Findings compareWithLaser(const DriveRecord& record, Axle axle, const std::vector<MotionWindow>& windows) {
  const Vehicle& vehicle = record.configuration.vehicle;
  std::vector<double> readings, angles;
  for (const MotionWindow& window : windows) {
    if (std::abs(window.motion.x()) < 0.5 * window.motion.head<2>().norm() ||
        std::abs(window.motion.x()) < 0.1)
      continue;
    readings.push_back(window.angle[axle]);
    angles.push_back(angleByLaser(vehicle, axle, window.motion));
  }
  if (readings.size() < kFewestWindows) return {};
  const Line line = fit(readings, angles);
  const SteeringWatch& watch = record.steering[index(axle)];
  const double noise = vehicle.rear_steering.source == RearSteering::Source::kMeasured ? 2.0 : 1.0;
  if (watch.highest - watch.lowest < kConstant) {
    if (line.angle_spread < noise * kSteered) return {};
    return {error(format("%s_steering stays at %.3f rad while the car turns", name(axle), watch.highest),
                  "check the sensor and its driver")};
  }
  Findings findings;
  if (line.slope < -kSignificant * line.slope_sigma)
    findings.push_back(error(format("%s_steering has the wrong sign: left must be positive", name(axle)),
                             format("--set %s=%.6g", key(axle).c_str(), -vehicle.steering[axle].scale)));
  if (isWrongScale(line)) findings.push_back(scaleFinding(record, axle, line));
  return findings;
}

Findings checkReadings(const DriveRecord& record, Axle axle) {
  const SteeringWatch& watch = record.steering[index(axle)];
  Findings findings;
  if (watch.not_finite > 0)
    findings.push_back(error(format("%s_steering: %lu readings are not finite", name(axle), watch.not_finite),
                             "mend the driver"));
  const double readings = static_cast<double>(watch.clock.messages());
  if (static_cast<double>(watch.beyond_limit) <= kManyBeyond * readings) return findings;
  const double largest = std::max(std::abs(watch.lowest), std::abs(watch.highest));
  findings.push_back(
      error(format("%s_steering reads up to %.4g rad, and %lu readings are beyond steering_limit, %.3g rad",
                   name(axle), largest, watch.beyond_limit, record.parameters.limits.steering_limit),
            largest < 90.0
                ? format("these are degrees: publish radians, or --set %s=%.6g", key(axle).c_str(),
                         record.configuration.vehicle.steering[axle].scale / kDegrees)
                : "these look like degrees of a steering wheel: divide by the steering ratio, and by 57.3"));
  return findings;
}

}  // namespace

Findings checkSteering(const DriveRecord& record, const std::vector<MotionWindow>& windows_by_laser) {
  Findings findings;
  for (const Axle axle : kAllAxles) {
    if (!record.steering_needed[axle] || record.steering[index(axle)].clock.messages() == 0) continue;
    Findings of_axle = checkReadings(record, axle);
    const bool measured =
        record.configuration.vehicle.rear_steering.source == RearSteering::Source::kMeasured;
    if (of_axle.empty() && (measured || lawTurns(record.configuration.vehicle)))
      of_axle = compareWithLaser(record, axle, windows_by_laser);
    const SteeringWatch& watch = record.steering[index(axle)];
    if (of_axle.empty())
      of_axle.push_back(
          fine(format("%s_steering: %.3f to %.3f rad", name(axle), watch.lowest, watch.highest)));
    append(of_axle, findings);
  }
  return findings;
}

}  // namespace bs_car_odometry::tools::doctor
