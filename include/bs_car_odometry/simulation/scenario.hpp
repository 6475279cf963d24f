#pragma once

#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/core/vehicle.hpp"

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace bs_car_odometry::simulation {

/// How a vehicle turns.
enum class Drivetrain {
  kSteered,       ///< by its axles' angles
  kDifferential,  ///< by the difference of its two rear wheels; a steering command becomes a yaw rate
};

/// Differential: only the rear wheels have encoders and are used, and the rear axle stands at angle 0.
Drivetrain drivetrainOf(const Vehicle& vehicle, AxleSelection axles);

/// What the driver asks for at one instant.
struct Command {
  double speed{0.0};        ///< V [m/s], of the rear axle's middle along its own angle
  double front_angle{0.0};  ///< phi_f [rad], left positive
  double yaw_rate{0.0};     ///< [rad/s], added to that of the angle; a differential robot's alone
};

/// One wheel rolls further than its contact point moves: an encoder fault, or a wheel that spins.
struct WheelSpin {
  Wheel wheel{Wheel::kRearRight};
  double from{0.0};   ///< [s]
  double until{0.0};  ///< [s]
  double speed{0.0};  ///< [m/s], added to the rolling speed
};

/// A drive: commands over time. The pattern repeats after `period`, so a drive may be as long as one likes.
struct Scenario {
  std::string name;
  double duration{0.0};                    ///< [s], of the drive
  double period{0.0};                      ///< [s], of the pattern
  std::function<Command(double)> pattern;  ///< for times in [0, period); without jumps, also across the end
  std::vector<WheelSpin> wheel_spins;      ///< times since the start of the drive, not repeated

  Command commandAt(double time) const;
};

/// Thrown for a name that is not in `scenarioNames()`, which it lists, and for a vehicle that cannot drive
/// the scenario because it cannot turn.
struct ScenarioError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// The scenario for this vehicle (corners last until it has turned 90 degrees).
/// @param speed_factor multiplies the speed; fig4, slalom_eight and circle keep their times, the others their
///                     lengths.
/// @throws ScenarioError
Scenario makeScenario(const std::string& name, const Vehicle& vehicle,
                      Drivetrain drivetrain = Drivetrain::kSteered, double speed_factor = 1.0);

std::vector<std::string> scenarioNames();

/// One line a scenario, for `--help`.
std::string scenarioDescriptions();

}  // namespace bs_car_odometry::simulation
