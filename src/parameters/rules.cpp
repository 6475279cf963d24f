#include "schema.hpp"

#include "bs_car_odometry/core/odometry_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace bs_car_odometry::schema {
namespace {

constexpr double kLargestAngle = 1.3;  // [rad], of an axle

bool uses(AxleSelection axles, Axle axle) {
  return axles == AxleSelection::kBoth || (axles == AxleSelection::kFront) == (axle == Axle::kFront);
}

bool isMeasured(const RearSteering& rear) { return rear.source == RearSteering::Source::kMeasured; }

std::string metresPerTickPath(Wheel wheel) { return std::string("encoders/metres_per_tick/") + name(wheel); }

bool encodersAccepted(const Report& report) {
  return std::all_of(kAllWheels.begin(), kAllWheels.end(),
                     [&](Wheel wheel) { return report.accepted({metresPerTickPath(wheel)}); });
}

void checkFrames(const Parameters& p, Report& report) {
  if (!report.accepted({"base_frame", "odom_frame"})) return;
  if (p.base_frame.empty()) report.problem("base_frame", "''", "is empty", "the name of a frame");
  if (p.odom_frame.empty()) report.problem("odom_frame", "''", "is empty", "the name of a frame");
  if (!p.odom_frame.empty() && p.odom_frame == p.base_frame)
    report.problem("odom_frame", quoted(p.odom_frame), "is base_frame as well",
                   "a name different from base_frame");
}

/// The kingpins of an axle must be some way apart.
void checkHubOffset(const Parameters& p, Axle axle, Report& report) {
  const std::string path = std::string("vehicle/hub_offset/") + name(axle);
  const std::string track_path = std::string("vehicle/track/") + name(axle);
  if (!report.accepted({path, track_path})) return;
  const double track = p.vehicle.track[axle];
  const double offset = p.vehicle.hub_offset[axle];
  if (track - 2.0 * offset > 0.0) return;
  report.problem(path, quoted(numberText(offset)), "is out of range",
                 "less than half of " + track_path + " (" + numberText(track) + ")");
}

/// |f(phi)| within the largest angle that an axle may have, over the steering range (S2).
void checkRearSteering(const Parameters& p, Report& report) {
  const std::string path = "vehicle/rear_steering/coefficients";
  if (!report.accepted({path, "vehicle/rear_steering/source", "steering_limit"})) return;
  if (isMeasured(p.vehicle.rear_steering)) return;
  // Dense enough for any polynomial that describes a linkage.
  constexpr int kSamples = 1000;
  const double limit = p.limits.steering_limit;
  for (int i = -kSamples; i <= kSamples; ++i) {
    const double phi_front = limit * i / kSamples;
    const double phi_rear = p.vehicle.rear_steering.angle(phi_front);
    if (std::abs(phi_rear) <= kLargestAngle) continue;
    report.problem(
        path, "",
        "the rear angle at a front angle of " + numberText(phi_front) + " is " + numberText(phi_rear),
        "a rear angle within +/-1.3 for front angles up to steering_limit (" + numberText(limit) + ") [rad]");
    return;
  }
}

void checkWheelsOfAxle(const Parameters& p, Axle axle, Report& report) {
  for (const Wheel wheel : {leftWheel(axle), rightWheel(axle)})
    if (!p.vehicle.hasEncoder(wheel))
      report.problem(metresPerTickPath(wheel), "'0'", "leaves the wheel without an encoder",
                     std::string("not 0, since odometry/axles is ") + name(axle));
}

void checkEncoders(const Parameters& p, Report& report) {
  if (!encodersAccepted(report) || !report.accepted({"odometry/axles"})) return;
  if (p.odometry.axles == AxleSelection::kFront) return checkWheelsOfAxle(p, Axle::kFront, report);
  if (p.odometry.axles == AxleSelection::kRear) return checkWheelsOfAxle(p, Axle::kRear, report);
  const auto encoders = std::count_if(kAllWheels.begin(), kAllWheels.end(),
                                      [&](Wheel wheel) { return p.vehicle.hasEncoder(wheel); });
  if (encoders < 2)
    report.problem("encoders/metres_per_tick", "", "only " + std::to_string(encoders) + " wheel(s) not 0",
                   "at least two wheels with an encoder");
}

/// The paper's equations are about one axle, and the unshortened track is a variant of its model A.
void checkMotion(const Parameters& p, Report& report) {
  if (!report.accepted({"odometry/axles", "odometry/motion", "odometry/shortened_track"})) return;
  const bool both = p.odometry.axles == AxleSelection::kBoth;
  const bool paper = p.odometry.motion == Motion::kPaper;
  if (paper && both)
    report.problem("odometry/motion", "'paper'", "does not go with odometry/axles both",
                   "exact, or odometry/axles front or rear");
  if (p.odometry.shortened_track) return;
  if (both)
    report.problem("odometry/shortened_track", "'false'", "does not go with odometry/axles both",
                   "true, or odometry/axles front or rear");
  if (!paper && report.accepted({"vehicle/axle_geometry"}) && p.vehicle.axle_geometry != AxleGeometry::kPivot)
    report.problem("odometry/shortened_track", "'false'", "does not go with vehicle/axle_geometry ackermann",
                   "true, or vehicle/axle_geometry pivot, or odometry/motion paper");
}

/// P1 calibrates the gains of one axle, and holds them to be constant.
void checkPaperCalibration(const Parameters& p, Report& report) {
  if (!report.accepted({"calibration/method"}) || p.calibration.method != CalibrationMethod::kPaper) return;
  if (report.accepted({"odometry/axles"}) && p.odometry.axles == AxleSelection::kBoth)
    report.problem("calibration/method", "'paper'", "does not go with odometry/axles both",
                   "joint, or odometry/axles front or rear");
  if (report.accepted({"calibration/estimate"}) &&
      p.calibration.estimate != std::vector<std::string>{"gains"})
    report.problem("calibration/estimate", "", "is not what calibration/method paper finds",
                   "[gains], or calibration/method joint");
  if (report.accepted({"calibration/gain_random_walk"}) && p.calibration.gain_random_walk != 0.0)
    report.problem("calibration/gain_random_walk", quoted(numberText(p.calibration.gain_random_walk)),
                   "does not go with calibration/method paper", "0, or calibration/method joint");
}

/// The mount comes either from tf or from the numbers.
void checkLaser(const Parameters& p, Report& report) {
  if (p.laser.frame.empty()) return;
  const std::pair<const char*, double> values[] = {
      {"laser/x", p.laser.x}, {"laser/y", p.laser.y}, {"laser/yaw", p.laser.yaw}};
  for (const auto& [path, value] : values)
    if (value != 0.0)
      report.problem(path, quoted(numberText(value)), "is given beside laser/frame",
                     "0, or an empty laser/frame");
}

/// The joints that the odometry reads, by the parameter that names them.
std::vector<std::pair<std::string, std::string>> usedJoints(const Parameters& p) {
  std::vector<std::pair<std::string, std::string>> joints;
  for (const Wheel wheel : kAllWheels)
    if (p.vehicle.hasEncoder(wheel) && uses(p.odometry.axles, axleOf(wheel)))
      joints.emplace_back(std::string("joints/") + name(wheel), p.joints.wheels[wheel]);
  const PerAxle<bool> needed = steeringNeeded(p.vehicle, p.odometry);
  for (const Axle axle : kAllAxles) {
    if (!needed[axle]) continue;
    const std::string path = std::string("joints/") + name(axle) + "_steering";
    if (p.joints.steering[axle].empty()) joints.emplace_back(path, "");
    for (const std::string& joint : p.joints.steering[axle]) joints.emplace_back(path, joint);
  }
  return joints;
}

void checkJoints(const Parameters& p, Report& report) {
  if (p.input != InputSource::kJointStates) return;
  if (!encodersAccepted(report) || !report.accepted({"odometry/axles", "vehicle/rear_steering/source"}))
    return;
  std::map<std::string, std::string> first_use;
  for (const auto& [path, joint] : usedJoints(p)) {
    if (!report.accepted({path})) continue;
    if (joint.empty()) {
      report.problem(path, "''", "is empty", "the name of a joint, with input joint_states");
    } else if (const auto [first, is_new] = first_use.emplace(joint, path); !is_new) {
      report.problem(path, quoted(joint), "is " + first->second + " as well", "a joint of its own");
    }
  }
}

}  // namespace

void stripLeadingSlashes(Parameters& p, Report& report) {
  const std::pair<const char*, std::string*> frames[] = {
      {"base_frame", &p.base_frame}, {"odom_frame", &p.odom_frame}, {"laser/frame", &p.laser.frame}};
  for (const auto& [path, frame] : frames) {
    const std::size_t slashes = std::min(frame->find_first_not_of('/'), frame->size());
    if (slashes == 0) continue;
    const std::string given = *frame;
    frame->erase(0, slashes);
    report.warning(std::string(path) + ": " + quoted(given) + " is taken as " + quoted(*frame) +
                   ", since tf2 knows no leading slash");
  }
}

void checkRules(const Parameters& parameters, Report& report) {
  checkFrames(parameters, report);
  for (const Axle axle : kAllAxles) checkHubOffset(parameters, axle, report);
  checkRearSteering(parameters, report);
  checkEncoders(parameters, report);
  checkMotion(parameters, report);
  checkPaperCalibration(parameters, report);
  checkLaser(parameters, report);
  checkJoints(parameters, report);
}

}  // namespace bs_car_odometry::schema
