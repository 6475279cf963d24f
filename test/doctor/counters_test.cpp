// Wraps at another width than configured, restarts, jumps.

#include "damaged_drive.hpp"

#include <gmock/gmock.h>

#include <array>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Damage onCounters(const std::function<void(std::int64_t&, double)>& damage) {
  return onWheels([=](WheelTicks& wheels) {
    const double t = (wheels.header.stamp - ros::Time(1600000000, 0)).toSec();
    for (std::int64_t* counter :
         {&wheels.front_left, &wheels.front_right, &wheels.rear_left, &wheels.rear_right})
      damage(*counter, t);
    return true;
  });
}

/// Coarse ticks, so that even 10 bits last much longer than a message.
Parameters coarse(int configured_bits) {
  Parameters car = cycab();
  car.vehicle.metres_per_tick = {{1e-3, 1e-3, 1e-3, 1e-3}};
  car.vehicle.counter_bits = configured_bits;
  return car;
}

/// The counters of the simulation, from 0 to 60,000, as a counter of `bits` would show them.
Damage wrapped(int bits, bool is_signed) {
  const std::int64_t range = std::int64_t{1} << bits;
  const std::int64_t lowest = is_signed ? -range / 2 : 0;
  return onCounters([=](std::int64_t& counter, double) { counter = (counter - lowest) % range + lowest; });
}

TEST(DoctorOfCounters, findsTheWidthAtWhichTheyWrap) {
  for (const int configured : {0, 32})
    for (const int bits : {10, 12, 14})
      for (const bool is_signed : {false, true})
        EXPECT_THAT(errors(Patient(coarse(configured)).examine(wrapped(bits, is_signed))),
                    AllOf(HasSubstr("the counter of front_left wraps at " + std::to_string(bits) + " bits"),
                          HasSubstr("--set encoders/counter_bits=" + std::to_string(bits))))
            << configured << " configured, " << (is_signed ? "signed" : "unsigned");
}

TEST(DoctorOfCounters, findsCountersBeyondTheirWidth) {
  Parameters configured = cycab();
  configured.vehicle.counter_bits = 16;
  EXPECT_THAT(
      errors(Patient(cycab()).examine(configured)),
      AllOf(HasSubstr("the counter of rear_right runs from 0 to "),
            HasSubstr("beyond encoders/counter_bits: 16"), HasSubstr("--set encoders/counter_bits=32")));
}

TEST(DoctorOfCounters, findsARestartAtZero) {
  std::array<std::int64_t, 4> at{};
  std::size_t wheel = 0;
  EXPECT_THAT(troubles(Patient(cycab()).examine(onCounters([&](std::int64_t& counter, double t) {
                std::int64_t& reference = at[wheel++ % 4];
                if (t < 25.0) reference = counter;
                if (t >= 25.0) counter -= reference;
              }))),
              HasSubstr("WARN   the counter of rear_left restarts at zero 1 times, last at 25.0 s"));
}

TEST(DoctorOfCounters, findsJumps) {
  EXPECT_THAT(
      troubles(Patient(cycab()).examine(onCounters([](std::int64_t& counter, double t) {
        if (t >= 25.0) counter += 123456789;
      }))),
      HasSubstr(
          "WARN   the counter of front_right jumps 1 times by more than max_speed allows, last at 25.0 s"));
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
