#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/fault_sentences.hpp"
#include "bs_car_odometry/ros/verdicts.hpp"

#include <algorithm>

namespace bs_car_odometry {

namespace {

const std::string& stateName(OdometryState state) {
  switch (state) {
    case OdometryState::kNominal:
      return OdometryStatus::NOMINAL;
    case OdometryState::kDegraded:
      return OdometryStatus::DEGRADED;
    case OdometryState::kNoSteering:
      return OdometryStatus::NO_STEERING;
  }
  return OdometryStatus::DEGRADED;
}

void fillCounts(const InputCounts& counts, OdometryStatus& message) {
  message.wheel_messages = counts.wheel_messages;
  message.steering_messages = counts.steering_messages;
  message.dropped_stamp_zero = counts[Verdict::kStampZero];
  message.dropped_stamp_invalid = counts[Verdict::kStampInvalid];
  message.dropped_repeated = counts[Verdict::kRepeated];
  message.dropped_out_of_order = counts[Verdict::kOutOfOrder];
  message.dropped_future = counts[Verdict::kFuture];
  message.dropped_not_finite = counts[Verdict::kNotFinite];
  message.dropped_steering_limit = counts[Verdict::kSteeringLimit];
  message.dropped_no_steering = counts[Verdict::kNoSteering];
  message.dropped_implausible = counts[Verdict::kImplausible];
  message.dropped_overflow = counts[Verdict::kOverflow];
  message.dropped_rival_publisher = counts[Verdict::kRivalPublisher];
  message.steering_held = counts.steering_held;
  message.counter_restarts = counts.counter_restarts;
  message.wheel_jumps = counts.wheel_jumps;
  message.gaps = counts.gaps;
  message.refused_states = counts.refused_states;
  message.ambiguous_gaps = counts.ambiguous_gaps;
  message.covariance_repairs = counts.covariance_repairs;
}

void fillQuantiles(const PoseQuantiles& quantiles, OdometryStatus& message) {
  const auto copy = [](const PoseQuantiles::Values& from, std::vector<double>& to) {
    to.assign(from.begin(), from.end());
  };
  copy(PoseQuantiles::kLevels, message.quantile_levels);
  copy(quantiles.x, message.quantiles_x);
  copy(quantiles.y, message.quantiles_y);
  copy(quantiles.yaw, message.quantiles_yaw);
}

void fillFaults(const SensorReport& report, OdometryStatus& message) {
  bool faulty = !report.determined;
  for (std::size_t i = 0; i < kSensors; ++i) {
    const SensorState& state = report.sensors[i];
    const auto fault = static_cast<std::uint8_t>(state.fault);
    faulty |= state.fault != SensorFault::kNone;
    if (isWheel(i)) {
      message.wheel_fault[i] = fault;
      message.wheel_ratio[i] = state.ratio;
    } else {
      message.steering_fault[i - kWheels] = fault;
    }
  }
  message.exclusions = report.exclusions;
  if (!faulty || message.state != OdometryStatus::NOMINAL) return;
  message.state = OdometryStatus::DEGRADED;
  message.reason = report.determined ? explain(report) : explainUndetermined(report);
}

}  // namespace

void fillStatus(const OdometryUpdate& update, const OutputFrames& frames, OdometryStatus& message) {
  const StepReport& report = update.report;
  message.header.stamp = toRos(update.stamp);
  message.header.frame_id = frames.base;
  message.state = stateName(report.state);
  message.reason = explain(report.state);
  fillFaults(report.sensors, message);
  message.interval = report.interval;
  message.step = report.step;
  for (std::size_t i = 0; i < kWheels; ++i) message.wheel_used[i] = report.wheel_used.values[i];
  const auto copy = [](const auto& from, auto& to) { std::copy(from.begin(), from.end(), to.begin()); };
  copy(report.wheel_travel.values, message.wheel_travel);
  copy(report.residuals.wheel.values, message.wheel_residual);
  for (const Axle axle : kAllAxles) {
    message.axle_residual[index(axle)] = report.residuals.axle[axle];
    message.steering_angle[index(axle)] = report.steering_angle[axle];
    message.steering_age[index(axle)] = report.steering_age[axle];
  }
  message.chi_square = report.residuals.chi_square;
  message.degrees_of_freedom = report.residuals.degrees_of_freedom;
  message.distance = report.distance;
  if (report.quantiles) fillQuantiles(*report.quantiles, message);
  fillCounts(report.counts, message);
}

}  // namespace bs_car_odometry
