#pragma once

#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/simulation/simulated_car.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry::laboratory {

/// What the sensors of the simulated car say at one instant, and where it truly is.
struct Sample {
  double time{0.0};  ///< [s] since the start
  PerWheel<std::int64_t> ticks;
  PerAxle<double> steering;  ///< [rad]
  simulation::Pose truth;    ///< of base_link in odom
};

/// A drive to be recorded.
struct DriveSettings {
  std::string scenario;
  double rate{20.0};                          ///< [Hz], wheels and steering together
  double duration{0.0};                       ///< [s], 0: the scenario's
  double speed_factor{1.0};                   ///< multiplies the scenario's speed
  AxleSelection axles{AxleSelection::kBoth};  ///< tells a differential robot from a car
  std::optional<NoiseModel> noise;            ///< none: exact but for rounding
  std::optional<SystematicNoise> draw_gains;  ///< p(A) of the true parameters; none: as configured
  std::uint64_t seed{1};
  double substep{0.005};  ///< [s]
};

/// @throws simulation::ScenarioError
std::vector<Sample> record(const Vehicle& vehicle, const DriveSettings& settings);

/// When the sample was taken, for the odometry.
Time stampOf(const Sample& sample);

/// Gives the odometry one sample, its angles just before its wheels.
/// @throws std::logic_error when that gives no odometry
OdometryUpdate step(OdometryPipeline& pipeline, const Sample& sample);

/// Runs the odometry over a recorded drive.
using Visitor = std::function<void(const Sample&, const OdometryUpdate&)>;
void replay(const OdometryConfiguration& configuration, const std::vector<Sample>& drive,
            const Visitor& visit);

}  // namespace bs_car_odometry::laboratory
