#pragma once

#include "../../src/tools/doctor/doctor.hpp"
#include "../tools/temporary_folder.hpp"

#include "bs_car_odometry/ros/simulated_drive.hpp"

#include <functional>
#include <string>

namespace bs_car_odometry::tools::testing {

/// The Cycab of config/cycab.yaml: four wheels, rear angle the negative of the front one.
Parameters cycab();

/// The same with a rear axle that stays straight, so that front and rear wheels can be told apart.
Parameters frontSteered();

/// The same with two wheels on an axle that is not steered.
Parameters differential();

/// What happens to a message before it is recorded. @return false: it is lost
using Damage = std::function<bool(SimulatedMessage&)>;

/// Damages of one kind of message alone; the others pass.
Damage onWheels(const std::function<bool(WheelTicks&)>& damage);
Damage onSteering(const std::function<bool(SteeringAngle&)>& damage);
Damage onLaser(const std::function<bool(geometry_msgs::PoseWithCovarianceStamped&)>& damage);

/// Records a simulated drive; the same settings give the same bag.
void recordDrive(const std::string& path, const Parameters& parameters,
                 const SimulatedDriveSettings& settings, const Damage& damage = {});

/// What the doctor says of a damaged drive.
class Patient {
 public:
  explicit Patient(Parameters parameters, std::string scenario = "slalom_eight")
      : parameters_(std::move(parameters)) {
    settings_.scenario = std::move(scenario);
  }

  SimulatedDriveSettings& settings() { return settings_; }
  Parameters& recordedWith() { return parameters_; }

  /// @param configured  what the doctor is told of the car
  doctor::Examination examine(const Parameters& configured, const Damage& damage = {},
                              const TopicNames& names = {}) const;
  doctor::Examination examine(const Damage& damage = {}) const { return examine(parameters_, damage); }

 private:
  Parameters parameters_;
  SimulatedDriveSettings settings_;
};

/// The lines of a report without those that are in order, or with them.
std::string troubles(const doctor::Examination& examination);
std::string report(const doctor::Examination& examination);

/// The lines with ERROR alone.
std::string errors(const doctor::Examination& examination);

}  // namespace bs_car_odometry::tools::testing
