#pragma once

#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/simulation/simulated_car.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry::drives {

/// What the sensors of the simulated car say at one instant, and where it truly is.
struct Sample {
  double time{0.0};  ///< [s] since the start
  PerWheel<std::int64_t> ticks;
  PerAxle<double> steering;  ///< [rad]
  simulation::Pose truth;    ///< of base_link in odom
};

/// A drive to be recorded. True gains are those of the vehicle, unless they are drawn.
struct DriveSettings {
  std::string scenario;
  double rate{20.0};                          ///< [Hz], wheels and steering together
  double duration{0.0};                       ///< [s], 0: the scenario's
  double speed_factor{1.0};                   ///< multiplies the scenario's speed
  AxleSelection axles{AxleSelection::kBoth};  ///< tells a differential robot from a car
  std::optional<NoiseModel> noise;            ///< none: exact but for rounding
  bool draw_parameters{false};                ///< true parameters from noise->systematic, by the seed
  std::uint64_t seed{1};
  double substep{0.005};  ///< [s]
};

std::vector<Sample> record(const Vehicle& vehicle, const DriveSettings& settings);

/// Runs the odometry over a recorded drive; every angle comes just before the wheels of its instant.
using Visitor = std::function<void(const Sample&, const OdometryEstimate&)>;
void replay(const OdometryConfiguration& configuration, const std::vector<Sample>& drive,
            const Visitor& visit);

/// What the odometry says of the motion from one sample to another, which need not be among the readings that
/// it is given: each `every`-th sample from the first one on.
/// @throws std::logic_error when it says nothing
MotionEstimate motionBetween(const OdometryConfiguration& configuration, const std::vector<Sample>& drive,
                             std::size_t from, std::size_t to, std::size_t every = 1);

/// The true one.
simulation::Pose trueMotion(const std::vector<Sample>& drive, std::size_t from, std::size_t to);

/// The odometry at the end of the drive.
OdometryEstimate endOf(const OdometryConfiguration& configuration, const std::vector<Sample>& drive);

/// Distance between odometry and truth [m]: at the end of the drive, and where it is largest.
struct Departure {
  double at_end{0.0};
  double largest{0.0};
};
Departure departure(const OdometryConfiguration& configuration, const std::vector<Sample>& drive);

/// Odometry of the vehicle with these axles, everything else as by default.
OdometryConfiguration odometryOf(const Vehicle& vehicle, AxleSelection axles);

/// For the names of tests.
const char* name(AxleSelection axles);
const char* name(AxleGeometry geometry);

}  // namespace bs_car_odometry::drives
