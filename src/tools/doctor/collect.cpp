#include "collect.hpp"

#include "bs_car_odometry/calibration/planar.hpp"
#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/odometry_adapter.hpp"

#include <cmath>

namespace bs_car_odometry::tools::doctor {

DriveRecord::DriveRecord(const Parameters& drive_parameters)
    : parameters(drive_parameters),
      configuration(toConfiguration(drive_parameters)),
      wheel_used(wheelsUsed(configuration.vehicle, configuration.options)),
      steering_needed(steeringNeeded(configuration.vehicle, configuration.options)),
      wheel_clock(configuration.limits),
      steering(kAxles, SteeringWatch(configuration.limits)),
      laser_clock(configuration.limits),
      laser_watch(drive_parameters.laser_sigma) {
  const Vehicle& vehicle = configuration.vehicle;
  for (const Wheel wheel : kAllWheels)
    counters.emplace_back(vehicle.counter_bits, vehicle.metres_per_tick[wheel],
                          configuration.limits.max_speed);
}

Collector::Stamps Collector::stampsOf(const ros::Time& stamp, const ros::Time& record_time) {
  const Time record = toTime(record_time).value_or(Time());
  if (record_.origin == Time()) record_.origin = record;
  const bool receipt = record_.parameters.stamp_source == StampSource::kReceipt;
  return {receipt ? std::optional<Time>(record) : toTime(stamp), record};
}

void Collector::add(const WheelTicks& message, const ros::Time& record_time) {
  addWheels(stampsOf(message.header.stamp, record_time),
            {{message.front_left, message.front_right, message.rear_left, message.rear_right}});
}

void Collector::add(Axle axle, const SteeringAngle& message, const ros::Time& record_time) {
  addSteering(axle, stampsOf(message.header.stamp, record_time), message.angle);
}

void Collector::add(const RawJointState& message, const ros::Time& record_time) {
  const std::optional<JointPositions> joints = readJointState(message);
  if (!joints) return;
  const Stamps stamps = stampsOf(joints->stamp, record_time);
  const Parameters& parameters = record_.parameters;
  const PerAxle<std::optional<double>> readings =
      axleReadings(parameters.vehicle, parameters.joints, *joints);
  for (const Axle axle : kAllAxles)
    if (readings[axle] && record_.steering_needed[axle]) addSteering(axle, stamps, *readings[axle]);
  PerWheel<std::int64_t> ticks;
  if (wheelTicksOf(*joints, ticks)) addWheels(stamps, ticks);
}

/// @return false for a message that lacks a wheel
bool Collector::wheelTicksOf(const JointPositions& joints, PerWheel<std::int64_t>& ticks) const {
  for (const Wheel wheel : kAllWheels) {
    if (!record_.wheel_used[wheel]) continue;
    const std::optional<double> position = joints[record_.parameters.joints.wheels[wheel]];
    if (!position || !(std::abs(*position) < kFarthestJoint)) return false;
    ticks[wheel] = std::llround(*position * kTicksPerRadian);
  }
  return true;
}

void Collector::addWheels(const Stamps& stamps, const PerWheel<std::int64_t>& ticks) {
  if (!record_.wheel_clock.add(stamps.stamp, stamps.record)) return;
  for (const Wheel wheel : kAllWheels) {
    if (!record_.wheel_used[wheel]) continue;
    const std::int64_t step = record_.counters[index(wheel)].add(ticks[wheel], *stamps.stamp);
    travel_[wheel] +=
        record_.configuration.vehicle.calibratedMetresPerTick(wheel) * static_cast<double>(step);
  }
  record_.wheels.add({record_.secondsOf(*stamps.stamp), travel_});
}

void Collector::addSteering(Axle axle, const Stamps& stamps, double reading) {
  SteeringWatch& watch = record_.steering[index(axle)];
  if (!watch.clock.add(stamps.stamp, stamps.record)) return;
  if (!std::isfinite(reading)) {
    ++watch.not_finite;
    return;
  }
  const SteeringCalibration& calibration = record_.configuration.vehicle.steering[axle];
  const double angle = calibration.scale * reading + calibration.offset;
  if (std::abs(angle) > record_.configuration.limits.steering_limit) ++watch.beyond_limit;
  watch.lowest = std::min(watch.lowest, angle);
  watch.highest = std::max(watch.highest, angle);
  watch.series.add({record_.secondsOf(*stamps.stamp), angle});
}

void Collector::add(const geometry_msgs::PoseWithCovarianceStamped& message, const ros::Time& record_time) {
  const Stamps stamps = stampsOf(message.header.stamp, record_time);
  if (!record_.laser_clock.add(stamps.stamp, stamps.record)) return;
  const std::optional<Pose2> pose = record_.laser_watch.add(message, *stamps.stamp);
  if (!pose) return;
  record_.laser.add({record_.secondsOf(*stamps.stamp), *pose});
}

void Collector::setMount(const LaserMount& mount) {
  record_.mount_known = true;
  const Pose2 base_in_laser = inverse(calibration::mountOf(mount));
  for (LaserSample& sample : record_.laser.samples()) sample.base = sample.base * base_in_laser;
}

}  // namespace bs_car_odometry::tools::doctor
