#include "noise_unknowns.hpp"

#include "bs_car_odometry/core/odometry_configuration.hpp"
#include "tool.hpp"

#include <algorithm>

namespace bs_car_odometry::tools {

namespace {

std::vector<UnknownNoise> pathNoise() {
  return {{"noise/wheel", [](NoiseModel& n) -> Distribution& { return n.wheel; }, 1e-3},
          {"noise/steering/std", [](NoiseModel& n) -> Distribution& { return n.steering.angle; }, 1e-3},
          {"noise/lateral", [](NoiseModel& n) -> Distribution& { return n.lateral; }, 1e-4},
          {"noise/rear_law", [](NoiseModel& n) -> Distribution& { return n.rear_law; }, 1e-3}};
}

std::vector<UnknownNoise> systematicNoise() {
  const auto entry = [](const char* name, Distribution SystematicNoise::*member) {
    return UnknownNoise{std::string("noise/systematic/") + name,
                        [member](NoiseModel& n) -> Distribution& { return n.systematic.*member; }, 1e-3};
  };
  return {entry("k_r", &SystematicNoise::k_r), entry("k_l", &SystematicNoise::k_l),
          entry("k_b", &SystematicNoise::k_b), entry("steering_offset", &SystematicNoise::steering_offset)};
}

UnknownGain gain(Axle axle, const char* key, double AxleGains::*member, double prior) {
  return {std::string("gains/") + name(axle) + "/" + key,
          [axle, member](Parameters& p) -> double& { return p.vehicle.gains[axle].*member; }, prior,
          std::string("noise/systematic/") + key};
}

/// Gains that the odometry uses, and steering offsets where they are asked for.
std::vector<UnknownGain> gainsOf(const Parameters& p) {
  std::vector<UnknownGain> gains;
  const PerWheel<bool> used = wheelsUsed(p.vehicle, p.odometry);
  const PerAxle<bool> steered = steeringNeeded(p.vehicle, p.odometry);
  const std::vector<std::string>& estimate = p.calibration.estimate;
  const bool offsets = std::find(estimate.begin(), estimate.end(), "steering_offset") != estimate.end();
  const CalibrationPrior& prior = p.calibration.prior;
  for (const Axle axle : kAllAxles) {
    const bool right = used[rightWheel(axle)];
    const bool left = used[leftWheel(axle)];
    if (right) gains.push_back(gain(axle, "k_r", &AxleGains::k_r, prior.k_r));
    if (left) gains.push_back(gain(axle, "k_l", &AxleGains::k_l, prior.k_l));
    if (right || left) gains.push_back(gain(axle, "k_b", &AxleGains::k_b, prior.k_b));
    if (offsets && steered[axle])
      gains.push_back({std::string("steering/") + name(axle) + "/offset",
                       [axle](Parameters& q) -> double& { return q.vehicle.steering[axle].offset; },
                       prior.steering_offset, "noise/systematic/steering_offset"});
  }
  return gains;
}

void requireVaries(const NoiseUnknowns& unknowns, const UnknownNoise& noise) {
  const auto varies = [&](const UnknownGain& gain) { return gain.systematic == noise.name; };
  if (std::none_of(unknowns.gains.begin(), unknowns.gains.end(), varies))
    throw InputError(noise.name + " cannot be found: what it is about is not estimated (odometry/axles, " +
                     "calibration/estimate)");
}

}  // namespace

std::vector<std::string> noiseNames() {
  std::vector<std::string> names;
  for (const UnknownNoise& noise : pathNoise()) names.push_back(noise.name);
  for (const UnknownNoise& noise : systematicNoise()) names.push_back(noise.name);
  return names;
}

NoiseUnknowns noiseUnknowns(const Parameters& parameters, const std::vector<std::string>& names) {
  const std::vector<std::string> known = noiseNames();
  for (const std::string& name : names)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw InputError("'" + name + "' is no noise that can be found; known: " + listed(known));
  const auto wanted = [&](const UnknownNoise& noise) {
    return std::find(names.begin(), names.end(), noise.name) != names.end();
  };
  NoiseUnknowns unknowns;
  unknowns.gains = gainsOf(parameters);
  for (const UnknownNoise& noise : pathNoise())
    if (wanted(noise)) unknowns.path.push_back(noise);
  for (const UnknownNoise& noise : systematicNoise()) {
    if (!wanted(noise)) continue;
    requireVaries(unknowns, noise);
    unknowns.systematic.push_back(noise);
  }
  return unknowns;
}

}  // namespace bs_car_odometry::tools
