#include "checks.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace bs_car_odometry::tools::doctor {

namespace {

constexpr double kDegrees = 180.0 / M_PI;
constexpr double kLagThatMatters = 0.015;  // [s]
constexpr double kSignificant = 3.0;       // sigma
constexpr double kYawThatMatters = 0.1;    // [rad], twice what the calibration leaves open
constexpr double kYawMistaken = 0.3;       // [rad]
constexpr double kStraight = 0.05;         // [rad] of turn in a window
constexpr double kLookingBack = 2.8;       // [rad]
constexpr double kStillLaser = 0.3;        // [m]
constexpr double kRolled = 3.0;            // [m]

std::string listedFrames(const LaserWatch& watch) {
  std::string text;
  for (const std::string& frame : watch.frames()) text += (text.empty() ? "'" : ", '") + frame + "'";
  return text;
}

Findings checkFrames(const DriveRecord& record) {
  const LaserWatch& watch = record.laser_watch;
  const std::string& base = record.parameters.base_frame;
  Findings findings;
  if (watch.frames().size() > 1)
    findings.push_back(error("laser_pose comes in several frames: " + listedFrames(watch),
                             "record one localiser only, in one map frame"));
  if (watch.frames().count("") > 0)
    findings.push_back(warning("laser_pose has an empty frame_id", "let the localiser name its map"));
  if (watch.frames().count(base) > 0 || watch.frames().count("/" + base) > 0)
    findings.push_back(error("laser_pose is given in " + base, "it must be a pose in a fixed map frame"));
  return findings;
}

Findings checkPoses(const DriveRecord& record) {
  const LaserWatch& watch = record.laser_watch;
  const unsigned long messages = record.laser_clock.messages();
  Findings findings;
  if (watch.notPoses() > 0)
    findings.push_back(error(format("laser_pose: %lu of %lu poses are not finite or have no quaternion",
                                    watch.notPoses(), messages),
                             "mend the localiser; these poses are dropped"));
  if (watch.badCovariances() > 0)
    findings.push_back(
        error(format("laser_pose: %lu of %lu covariances are not finite or not positive definite",
                     watch.badCovariances(), messages),
              "mend the localiser; these poses are dropped"));
  if (watch.withoutCovariance() > 0)
    findings.push_back(warning(
        format("laser_pose: %lu of %lu poses have no covariance", watch.withoutCovariance(), messages),
        format("laser_sigma holds for them, %g m and %g rad: set what the localiser is worth",
               record.parameters.laser_sigma.position, record.parameters.laser_sigma.yaw)));
  if (watch.jumps() > 0)
    findings.push_back(
        warning(format("laser_pose jumps %lu times, by up to %.2f m and %.0f deg (at %.1f s)", watch.jumps(),
                       watch.largestJump(), watch.largestTurn() * kDegrees, record.secondsOf(watch.jumpAt())),
                "outliers are believed less and a new place is taken up; look at the localiser"));
  return findings;
}

double pathOf(const std::vector<WheelSample>& wheels, Wheel wheel) {
  double path = 0.0;
  for (std::size_t i = 1; i < wheels.size(); ++i)
    path += std::abs(wheels[i].travel[wheel] - wheels[i - 1].travel[wheel]);
  return path;
}

/// A localiser that is lost may go on saying where it was.
Findings checkMoves(const DriveRecord& record) {
  const std::vector<LaserSample>& laser = record.laser.samples();
  double rolled = 0.0;
  for (const Wheel wheel : kAllWheels) rolled = std::max(rolled, pathOf(record.wheels.samples(), wheel));
  if (laser.empty() || rolled < kRolled) return {};
  const auto moved = [&laser](const LaserSample& sample) {
    return (sample.base.position() - laser.front().base.position()).norm() > kStillLaser ||
           std::abs(sample.base.yaw - laser.front().base.yaw) > kStillLaser;
  };
  if (std::any_of(laser.begin(), laser.end(), moved)) return {};
  return {error(format("laser_pose stays where it is while the wheels roll %.1f m", rolled),
                "is the localiser running, and does it know its map?")};
}

Finding lagFinding(const DriveRecord& record, const LaserLag& lag) {
  const double configured = record.parameters.laser.time_offset;
  const std::string figure = format("laser_pose is %.0f +/- %.0f ms %s", std::abs(lag.lag) * 1e3,
                                    lag.sigma * 1e3, lag.lag < 0.0 ? "early" : "late");
  const double off = std::abs(lag.lag - configured);
  const std::vector<std::string>& estimate = record.parameters.calibration.estimate;
  if (off < std::max(kLagThatMatters, kSignificant * lag.sigma)) return fine(figure);
  if (std::find(estimate.begin(), estimate.end(), "time_offset") != estimate.end())
    return fine(figure + ", and time_offset is estimated");
  return warning(
      figure + format(", where laser/time_offset is %g s", configured),
      format("--set laser/time_offset=%.3f, or --set 'calibration/estimate=[gains, time_offset]'", lag.lag));
}

}  // namespace

Findings checkLaser(const DriveRecord& record) {
  Findings findings = checkFrames(record);
  append(checkPoses(record), findings);
  append(checkMoves(record), findings);
  if (findings.empty() && !record.laser.samples().empty())
    findings.push_back(
        fine("laser_pose: frame " + listedFrames(record.laser_watch) + ", no jump, covariances in order"));
  return findings;
}

Findings checkLag(const DriveRecord& record, const std::optional<LaserLag>& lag) {
  if (record.laser.samples().empty() || record.wheels.samples().empty()) return {};
  if (!lag) return {fine("laser_pose: whether it is late does not show: the car hardly turns or speeds up")};
  return {lagFinding(record, *lag)};
}

Findings checkLaserYaw(const DriveRecord& record, const std::vector<MotionWindow>& windows) {
  Eigen::Vector2d ahead = Eigen::Vector2d::Zero();
  for (const MotionWindow& window : windows) {
    double way = 0.0;
    for (const Wheel wheel : kAllWheels) way += record.wheel_used[wheel] ? window.travel[wheel] : 0.0;
    if (std::abs(window.motion.z()) < kStraight && way != 0.0)
      ahead += std::copysign(1.0, way) * window.motion.head<2>();
  }
  if (ahead.norm() < 1.0) return {};
  const double yaw = std::atan2(ahead.y(), ahead.x());
  if (std::abs(yaw) < kYawThatMatters || std::abs(yaw) > kLookingBack) return {};
  const std::string text =
      format("by its poses the laser is turned by %.1f deg against laser/yaw", -yaw * kDegrees);
  const std::string remedy = format("--set laser/yaw=%.3f", wrapAngle(record.parameters.laser.yaw - yaw));
  if (std::abs(yaw) > kYawMistaken) return {error(text, remedy)};
  return {warning(text, remedy + ", or estimate laser_mount")};
}

}  // namespace bs_car_odometry::tools::doctor
