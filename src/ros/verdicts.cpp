#include "bs_car_odometry/ros/verdicts.hpp"

#include <array>
#include <cmath>
#include <cstdio>

namespace bs_car_odometry {

namespace {

constexpr double kRadiansPerDegree = M_PI / 180.0;

/// Beyond what any car's wheels turn by in radians, and within it in degrees.
bool looksLikeDegrees(double angle) {
  constexpr double kFurthest = 1.3;  // [rad], see steering_limit
  return std::abs(angle) > kFurthest && std::abs(angle) * kRadiansPerDegree <= kFurthest;
}

}  // namespace

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
      return "its angle is beyond 'steering_limit': is the sensor sound, and are steering/scale and offset "
             "right?";
    case Verdict::kNoSteering:
      return "no steering angle is known yet: is the steering topic published, and remapped to this node?";
    case Verdict::kImplausible:
      return "its counters are further on than 'max_speed' allows: check encoders/metres_per_tick and "
             "counter_bits";
    case Verdict::kOverflow:
      return "too many wheel messages wait for steering: lower 'steering_wait', or raise the rate of the "
             "steering";
    case Verdict::kRivalPublisher:
      return "another node publishes on this input and is heard: stop one of them, or remap its topic";
  }
  return "";
}

std::string explain(Verdict verdict, const InputCounts& counts) {
  std::array<char, 160> known{};
  if (verdict == Verdict::kFuture)
    std::snprintf(known.data(), known.size(), " (by %.3f s)", toSeconds(counts.ahead));
  if (verdict == Verdict::kSteeringLimit && looksLikeDegrees(counts.refused_angle))
    std::snprintf(known.data(), known.size(),
                  " (%.4g would be %.3f rad if it were in degrees: set steering/front/scale or "
                  "steering/rear/scale to 0.0174533)",
                  counts.refused_angle, counts.refused_angle * kRadiansPerDegree);
  return std::string(explain(verdict)) + known.data();
}

bool isError(Verdict verdict) {
  return verdict == Verdict::kStampZero || verdict == Verdict::kStampInvalid ||
         verdict == Verdict::kRivalPublisher;
}

const char* explainAmbiguousGap() {
  return "no wheel message for so long that the counters may have wrapped unseen: the pose is kept, and its "
         "covariance allows for max_speed; raise the driver's rate, or count with more bits";
}

const char* explainRepair() {
  return "a covariance was not positive semidefinite, and the nearest one that is was taken: does set_pose "
         "or "
         "initial_pose carry one that is none, or is the pose known too badly for exact_moments?";
}

const char* explain(OdometryState state) {
  switch (state) {
    case OdometryState::kNominal:
      return "";
    case OdometryState::kDegraded:
      return "a step was undone because its result was not finite, or further than max_speed allows: check "
             "the vehicle's file";
    case OdometryState::kNoSteering:
      return "the steering angle is older than 'max_steering_age': check the steering sensor and its rate";
  }
  return "";
}

}  // namespace bs_car_odometry
