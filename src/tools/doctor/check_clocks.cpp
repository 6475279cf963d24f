#include "checks.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace bs_car_odometry::tools::doctor {

namespace {

constexpr double kIrregular = 3.0;      ///< 95 % quantile of the intervals against their median
constexpr double kSlowWheels = 5.0;     // [Hz]
constexpr double kSlowLaser = 1.0;      // [Hz]
constexpr double kLongLaserGap = 10.0;  // [s]: dead reckoning bridges less
constexpr double kLate = 0.5;           // [s] record after stamp, beyond what transport takes
constexpr double kClocksApart = 0.25;   // [s] between the offsets of two topics
constexpr double kSmallOverlap = 0.5;   ///< share of the wheels' time that the laser covers

const char* const kReceipt = "stamp the messages at the source, or set stamp_source: receipt";

Findings checkStamps(const std::string& topic, const StampStatistics& clock) {
  Findings findings;
  const auto messages = clock.messages();
  if (clock.zero() > 0)
    findings.push_back(error(
        format("%s: %lu of %lu messages have stamp zero or none", topic.c_str(), clock.zero(), messages),
        kReceipt));
  if (clock.future() > 0)
    findings.push_back(
        error(format("%s: %lu of %lu stamps are later than their record, by %.3f s in the middle",
                     topic.c_str(), clock.future(), messages, -clock.offset(0.5)),
              "synchronise the clocks (chrony), or set stamp_source: receipt"));
  if (clock.backwards() > 0)
    findings.push_back(
        warning(format("%s: %lu of %lu stamps jump back, by up to %.3f s", topic.c_str(), clock.backwards(),
                       messages, toSeconds(clock.furthestBack())),
                "is only one driver running, and its clock steady? These messages are dropped"));
  if (clock.repeated() > 0)
    findings.push_back(warning(
        format("%s: %lu of %lu stamps repeat the one before", topic.c_str(), clock.repeated(), messages),
        "is only one driver running? These messages are dropped"));
  if (clock.offset(0.5) > kLate)
    findings.push_back(
        warning(format("%s: recorded %.2f s after the stamps", topic.c_str(), clock.offset(0.5)),
                "synchronise the clocks of sensor and recorder (chrony)"));
  return findings;
}

/// @param gap      [s] longest that is in order
Findings checkRate(const std::string& topic, const StampStatistics& clock, double gap, double slow,
                   const DriveRecord& record) {
  Findings findings;
  if (clock.rate() < slow)
    findings.push_back(
        warning(format("%s: %.3g Hz, less than %g Hz", topic.c_str(), clock.rate(), slow), "raise the rate"));
  if (clock.interval(0.95) > kIrregular * clock.interval(0.5))
    findings.push_back(warning(
        format("%s: irregular, one interval in twenty is longer than %.3f s where half are below %.3f s",
               topic.c_str(), clock.interval(0.95), clock.interval(0.5)),
        "look for lost messages, and stamp at the sensor and not on arrival"));
  if (clock.longestGap() > gap)
    findings.push_back(
        warning(format("%s: %lu gaps beyond max_gap, the longest %.2f s at %.1f s", topic.c_str(),
                       clock.gaps(), clock.longestGap(), record.secondsOf(clock.longestGapAt())),
                "look for lost messages; what the car did meanwhile counts little"));
  return findings;
}

Finding inOrder(const std::string& topic, const StampStatistics& clock) {
  return fine(format("%s: %lu messages, %.1f Hz, longest interval %.3f s", topic.c_str(), clock.messages(),
                     clock.rate(), clock.longestGap()));
}

Findings checkTopic(const std::string& topic, const StampStatistics& clock, double gap, double slow,
                    const DriveRecord& record) {
  if (clock.messages() == 0) return {};
  Findings findings = checkStamps(topic, clock);
  if (clock.first()) append(checkRate(topic, clock, gap, slow, record), findings);
  if (findings.empty()) findings.push_back(inOrder(topic, clock));
  return findings;
}

/// Two machines whose clocks differ show by the time from stamp to record.
Findings compareClocks(const DriveRecord& record) {
  const StampStatistics& wheels = record.wheel_clock;
  const StampStatistics& laser = record.laser_clock;
  if (!wheels.first() || !laser.first()) return {};
  const double overlap =
      toSeconds(std::min(*wheels.last(), *laser.last()) - std::max(*wheels.first(), *laser.first()));
  if (overlap <= 0.0)
    return {error("laser_pose and the wheels have no stamps in common",
                  "record both at once, and synchronise their clocks (chrony)")};
  Findings findings;
  if (overlap < kSmallOverlap * wheels.duration())
    findings.push_back(warning(format("laser_pose covers %.1f s of the %.1f s that the wheels were recorded",
                                      overlap, wheels.duration()),
                               "start the localiser before the drive"));
  const double apart = laser.offset(0.5) - wheels.offset(0.5);
  if (std::abs(apart) > kClocksApart)
    findings.push_back(
        warning(format("laser_pose is recorded %.2f s later after its stamp than the wheels", apart),
                "is that the localiser's computing time? If not, synchronise the clocks (chrony)"));
  return findings;
}

}  // namespace

Findings checkClocks(const DriveRecord& record) {
  const double max_gap = toSeconds(record.configuration.limits.max_gap);
  const bool joints = record.parameters.input == InputSource::kJointStates;
  Findings findings =
      checkTopic(joints ? "joint_states" : "wheel_ticks", record.wheel_clock, max_gap, kSlowWheels, record);
  for (const Axle axle : kAllAxles)
    if (record.steering_needed[axle] && !joints)
      append(checkTopic(std::string(name(axle)) + "_steering", record.steering[index(axle)].clock, max_gap,
                        kSlowWheels, record),
             findings);
  append(checkTopic("laser_pose", record.laser_clock, kLongLaserGap, kSlowLaser, record), findings);
  append(compareClocks(record), findings);
  return findings;
}

}  // namespace bs_car_odometry::tools::doctor
