#include "bs_car_odometry/calibration/calibrated_parameters.hpp"

#include "bs_car_odometry/core/odometry_configuration.hpp"

#include <algorithm>

namespace bs_car_odometry::calibration {

namespace {

constexpr std::array<const char*, kCount> kNames{"front/k_r",
                                                 "front/k_l",
                                                 "front/k_b",
                                                 "front/steering_offset",
                                                 "rear/k_r",
                                                 "rear/k_l",
                                                 "rear/k_b",
                                                 "rear/steering_offset",
                                                 "front/steering_scale",
                                                 "rear/steering_scale",
                                                 "laser/x",
                                                 "laser/y",
                                                 "laser/yaw",
                                                 "laser/time_offset"};

// What is left open by a tape measure [m], by eye [rad], and by a localiser that does not tell its delay [s].
constexpr double kLaserPositionPrior = 0.2;
constexpr double kLaserYawPrior = 0.1;
constexpr double kTimeOffsetPrior = 0.2;

struct AxleIndices {
  Eigen::Index k_r, k_l, k_b, offset, scale;
};

constexpr AxleIndices indicesOf(Axle axle) {
  using namespace systematic;
  return axle == Axle::kFront ? AxleIndices{kFrontRight, kFrontLeft, kFrontTrack, kFrontOffset, kFrontScale}
                              : AxleIndices{kRearRight, kRearLeft, kRearTrack, kRearOffset, kRearScale};
}

bool asks(const Parameters& parameters, const char* group) {
  const auto& estimate = parameters.calibration.estimate;
  return std::find(estimate.begin(), estimate.end(), group) != estimate.end();
}

void selectGains(const Parameters& parameters, Axle axle, ParameterMask& mask) {
  const PerWheel<bool> used = wheelsUsed(parameters.vehicle, parameters.odometry);
  const AxleIndices i = indicesOf(axle);
  mask[i.k_r] = used[rightWheel(axle)];
  mask[i.k_l] = used[leftWheel(axle)];
  mask[i.k_b] = mask[i.k_r] && mask[i.k_l];
}

}  // namespace

std::string parameterName(std::size_t parameter) { return kNames.at(parameter); }

std::optional<std::size_t> parameterNamed(const std::string& name) {
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<std::size_t>(found - kNames.begin());
}

ParameterMask parametersToEstimate(const Parameters& parameters) {
  ParameterMask mask{};
  const PerAxle<bool> steered = steeringNeeded(parameters.vehicle, parameters.odometry);
  for (const Axle axle : kAllAxles) {
    const AxleIndices i = indicesOf(axle);
    if (asks(parameters, "gains")) selectGains(parameters, axle, mask);
    mask[i.offset] = steered[axle] && asks(parameters, "steering_offset");
    mask[i.scale] = steered[axle] && asks(parameters, "steering_scale");
  }
  mask[kLaserX] = mask[kLaserY] = mask[kLaserYaw] = asks(parameters, "laser_mount");
  mask[kTimeOffset] = asks(parameters, "time_offset");
  return mask;
}

ParameterVector valuesOf(const Parameters& parameters) {
  ParameterVector values;
  for (const Axle axle : kAllAxles) {
    const AxleIndices i = indicesOf(axle);
    const AxleGains& gains = parameters.vehicle.gains[axle];
    values[i.k_r] = gains.k_r;
    values[i.k_l] = gains.k_l;
    values[i.k_b] = gains.k_b;
    values[i.offset] = parameters.vehicle.steering[axle].offset;
    values[i.scale] = parameters.vehicle.steering[axle].scale;
  }
  const LaserMount& laser = parameters.laser;
  values.tail<4>() << laser.x, laser.y, laser.yaw, laser.time_offset;
  return values;
}

void setValues(const ParameterVector& values, Vehicle& vehicle) {
  for (const Axle axle : kAllAxles) {
    const AxleIndices i = indicesOf(axle);
    vehicle.gains[axle] = {values[i.k_r], values[i.k_l], values[i.k_b]};
    vehicle.steering[axle] = {values[i.scale], values[i.offset]};
  }
}

void setValues(const ParameterVector& values, Parameters& parameters) {
  setValues(values, parameters.vehicle);
  LaserMount& laser = parameters.laser;
  laser.x = values[kLaserX];
  laser.y = values[kLaserY];
  laser.yaw = values[kLaserYaw];
  laser.time_offset = values[kTimeOffset];
}

ParameterVector priorDeviations(const Parameters& parameters) {
  const CalibrationPrior& prior = parameters.calibration.prior;
  ParameterVector deviations;
  for (const Axle axle : kAllAxles) {
    const AxleIndices i = indicesOf(axle);
    deviations[i.k_r] = prior.k_r;
    deviations[i.k_l] = prior.k_l;
    deviations[i.k_b] = prior.k_b;
    deviations[i.offset] = prior.steering_offset;
    deviations[i.scale] = prior.steering_scale;
  }
  deviations.tail<4>() << kLaserPositionPrior, kLaserPositionPrior, kLaserYawPrior, kTimeOffsetPrior;
  const ParameterMask estimated = parametersToEstimate(parameters);
  for (std::size_t i = 0; i < kCount; ++i)
    if (!estimated[i]) deviations[static_cast<Eigen::Index>(i)] = 0.0;
  return deviations;
}

}  // namespace bs_car_odometry::calibration
