#include "bs_car_odometry/ros/verdicts.hpp"

#include <array>
#include <cstdio>

namespace bs_car_odometry {

const char* explain(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAccepted:
    case Verdict::kCount:
      return "";
    case Verdict::kStampZero:
      return "its stamp is zero: stamp messages at the source, or set 'stamp_source: receipt'";
    case Verdict::kStampInvalid:
      return "its stamp has a second or more in nanoseconds: mend the publisher, or set 'stamp_source: "
             "receipt'";
    case Verdict::kRepeated:
      return "a message with this stamp was there already: do two drivers publish, or is it stamped twice?";
    case Verdict::kOutOfOrder:
      return "it is older than what was used already: is the driver's clock steady, and only one running?";
    case Verdict::kFuture:
      return "its stamp is ahead of this clock by more than 'max_future': synchronise the clocks, or set "
             "'stamp_source: receipt'";
    case Verdict::kNotFinite:
      return "its value is missing or not a finite number: mend the driver";
    case Verdict::kSteeringLimit:
      return "its angle is beyond 'steering_limit': are the readings in degrees, or is steering/scale wrong?";
    case Verdict::kNoSteering:
      return "no steering angle is known yet: is the steering topic published, and remapped to this node?";
    case Verdict::kImplausible:
      return "its counters are further on than 'max_speed' allows: check encoders/metres_per_tick and "
             "counter_bits";
    case Verdict::kOverflow:
      return "too many wheel messages wait for steering: lower 'steering_wait', or raise the rate of the "
             "steering";
  }
  return "";
}

std::string explain(Verdict verdict, const InputCounts& counts) {
  std::string sentence = explain(verdict);
  if (verdict != Verdict::kFuture) return sentence;
  std::array<char, 32> ahead{};
  std::snprintf(ahead.data(), ahead.size(), " (by %.3f s)", toSeconds(counts.ahead));
  return sentence + ahead.data();
}

const char* explain(OdometryState state) {
  switch (state) {
    case OdometryState::kNominal:
      return "";
    case OdometryState::kDegraded:
      return "a step was undone because its result was not finite: check the vehicle's file";
    case OdometryState::kNoSteering:
      return "the steering angle is older than 'max_steering_age': check the steering sensor and its rate";
  }
  return "";
}

}  // namespace bs_car_odometry
