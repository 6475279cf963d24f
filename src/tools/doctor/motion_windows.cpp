#include "motion_windows.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::tools::doctor {

namespace {

constexpr double kWindowTurn = 0.25;       // [rad]
constexpr double kShortest = 0.2;          // [m]
constexpr double kLongestDuration = 10.0;  // [s] without getting anywhere
constexpr double kAfterJump = 1.0;         // [s] in which a localiser may jump back

double windowLength(const Vehicle& vehicle) { return std::max(kShortest, 0.8 * vehicle.wheelbase); }

PerWheel<double> travelAt(const Series<WheelSample>& wheels, std::size_t before, double t) {
  const WheelSample& a = wheels.samples()[before];
  const WheelSample& b = wheels.samples()[before + 1];
  const double share = (t - a.t) / (b.t - a.t);
  PerWheel<double> travel;
  for (const Wheel wheel : kAllWheels)
    travel[wheel] = a.travel[wheel] + share * (b.travel[wheel] - a.travel[wheel]);
  return travel;
}

/// Mean of the readings between, or of the two around where there is none. @return false without any
bool meanAngle(const Series<AngleSample>& series, double begin, double end, double& angle) {
  const std::size_t first = series.before(begin);
  const std::size_t last = series.before(end);
  const std::vector<AngleSample>& samples = series.samples();
  if (first >= samples.size() || last >= samples.size()) return false;
  double sum = 0.0;
  for (std::size_t i = first; i <= last + 1; ++i) sum += samples[i].angle;
  angle = sum / static_cast<double>(last + 2 - first);
  return true;
}

bool readSensors(const DriveRecord& record, MotionWindow& window) {
  if (!travelBetween(record, window.begin, window.end, window.travel)) return false;
  for (const Axle axle : kAllAxles)
    if (record.steering_needed[axle] &&
        !meanAngle(record.steering[index(axle)].series, window.begin, window.end, window.angle[axle]))
      return false;
  return true;
}

bool holdsJump(const DriveRecord& record, double begin, double end) {
  const std::vector<Time>& jumps = record.laser_watch.jumpTimes();
  return std::any_of(jumps.begin(), jumps.end(), [&](Time jump) {
    const double t = record.secondsOf(jump);
    return begin < t + kAfterJump && t <= end;
  });
}

double middle(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

/// What most wheels say of the way that the car has gone [m].
double middleTravel(const DriveRecord& record, const PerWheel<double>& travel) {
  std::vector<double> used;
  for (const Wheel wheel : kAllWheels)
    if (record.wheel_used[wheel]) used.push_back(travel[wheel]);
  return used.empty() ? 0.0 : middle(used);
}

}  // namespace

SteeringAngles anglesOf(const Vehicle& vehicle, const PerAxle<double>& read) {
  const bool by_law = vehicle.rear_steering.source == RearSteering::Source::kPolynomial;
  return {read.front, by_law ? vehicle.rear_steering.angle(read.front) : read.rear};
}

bool travelBetween(const DriveRecord& record, double begin, double end, PerWheel<double>& travel) {
  const std::size_t first = record.wheels.before(begin);
  const std::size_t last = record.wheels.before(end);
  const std::size_t none = record.wheels.samples().size();
  if (first >= none || last >= none) return false;
  const PerWheel<double> from = travelAt(record.wheels, first, begin);
  const PerWheel<double> to = travelAt(record.wheels, last, end);
  for (const Wheel wheel : kAllWheels) travel[wheel] = to[wheel] - from[wheel];
  return true;
}

std::vector<MotionWindow> windowsByLaser(const DriveRecord& record, double lag) {
  const std::vector<LaserSample>& laser = record.laser.samples();
  const double length = windowLength(record.configuration.vehicle);
  std::vector<MotionWindow> windows;
  std::size_t from = 0;
  for (std::size_t to = 1; to < laser.size(); ++to) {
    const Pose2 moved = inverse(laser[from].base) * laser[to].base;
    const bool enough = moved.position().norm() >= length || std::abs(moved.yaw) >= kWindowTurn;
    const bool too_long = laser[to].t - laser[from].t > kLongestDuration;
    if (!enough && !too_long) continue;
    MotionWindow window{laser[from].t - lag, laser[to].t - lag, log(moved), {}, {}};
    if (enough && !too_long && !holdsJump(record, laser[from].t, laser[to].t) && readSensors(record, window))
      windows.push_back(window);
    from = to;
  }
  return windows;
}

std::vector<MotionWindow> windowsBySteering(const DriveRecord& record) {
  const Vehicle& vehicle = record.configuration.vehicle;
  if (!record.steering_needed.front && !record.steering_needed.rear) return {};
  const std::vector<WheelSample>& wheels = record.wheels.samples();
  std::vector<MotionWindow> windows;
  std::size_t from = 0;
  for (std::size_t to = 1; to + 1 < wheels.size(); ++to) {
    PerWheel<double> rolled;
    for (const Wheel wheel : kAllWheels)
      rolled[wheel] = wheels[to].travel[wheel] - wheels[from].travel[wheel];
    const double way = middleTravel(record, rolled);
    if (std::abs(way) < windowLength(vehicle)) continue;
    MotionWindow window{wheels[from].t, wheels[to].t, {}, {}, {}};
    from = to;
    if (!readSensors(record, window)) continue;
    const SteeringAngles angles = anglesOf(vehicle, window.angle);
    const double limit = record.configuration.limits.steering_limit;
    if (std::abs(angles.front) > limit || std::abs(angles.rear) > limit) continue;
    const PathShape shape = pathShape(vehicle, angles);
    window.motion = BodyMotion(way, shape.sideslip * way, shape.curvature * way);
    windows.push_back(window);
  }
  return windows;
}

}  // namespace bs_car_odometry::tools::doctor
