#include "checks.hpp"

#include <string>

namespace bs_car_odometry::tools::doctor {

namespace {

Finding wrapsElsewhere(const char* wheel, const CounterWatch& counter, int configured) {
  return error(format("the counter of %s wraps at %d bits, where encoders/counter_bits is %d", wheel,
                      counter.foundBits(), configured),
               format("--set encoders/counter_bits=%d", counter.foundBits()));
}

Finding exceeds(const char* wheel, const CounterWatch& counter, int configured) {
  return error(format("the counter of %s runs from %ld to %ld, beyond encoders/counter_bits: %d", wheel,
                      counter.lowest(), counter.highest(), configured),
               configured < 32 ? "--set encoders/counter_bits=32, or 0 when it never wraps"
                               : "--set encoders/counter_bits=0");
}

Finding restarted(const DriveRecord& record, const char* wheel, const CounterWatch& counter) {
  return warning(format("the counter of %s restarts at zero %lu times, last at %.1f s", wheel,
                        counter.restarts(), record.secondsOf(counter.restartAt())),
                 "is the driver started again on the way? The motion meanwhile is lost");
}

Finding jumped(const DriveRecord& record, const char* wheel, const CounterWatch& counter) {
  return warning(format("the counter of %s jumps %lu times by more than max_speed allows, last at %.1f s",
                        wheel, counter.jumps(), record.secondsOf(counter.jumpAt())),
                 "check the encoder's cable, counter_bits and metres_per_tick");
}

}  // namespace

Findings checkCounters(const DriveRecord& record) {
  const int bits = record.configuration.vehicle.counter_bits;
  Findings findings;
  unsigned long wraps = 0;
  for (const Wheel wheel : kAllWheels) {
    if (!record.wheel_used[wheel]) continue;
    const CounterWatch& counter = record.counters[index(wheel)];
    wraps += counter.wraps();
    if (counter.exceedsWidth()) findings.push_back(exceeds(name(wheel), counter, bits));
    if (counter.foundBits() > 0) findings.push_back(wrapsElsewhere(name(wheel), counter, bits));
    if (counter.restarts() > 0) findings.push_back(restarted(record, name(wheel), counter));
    if (counter.jumps() > 0) findings.push_back(jumped(record, name(wheel), counter));
  }
  if (findings.empty()) findings.push_back(fine(format("counters: %lu wraps, no restart, no jump", wraps)));
  return findings;
}

}  // namespace bs_car_odometry::tools::doctor
