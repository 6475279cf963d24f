#pragma once

#include "bs_car_odometry/calibration/calibrator.hpp"
#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"
#include "bs_car_odometry/simulation/random.hpp"
#include "bs_car_odometry/simulation/simulated_car.hpp"

#include <cstdint>
#include <deque>
#include <functional>
#include <string>

namespace bs_car_odometry::calibration {

/// A Cycab with the default noise, 0.1 mm a tick: `config/cycab.yaml`.
Parameters cycabWithLaser();

/// How a simulated car is driven and what its laser does.
struct CarSettings {
  Parameters parameters{cycabWithLaser()};
  simulation::Scenario scenario;
  std::uint64_t seed{1};
  double rate{50.0};                            ///< [Hz], wheels and steering
  int steps_per_pose{5};                        ///< a laser pose after so many of them
  double laser_latency{0.0};                    ///< [s] from a laser pose's stamp to its receipt
  double laser_lag{0.0};                        ///< [s] by which its stamp is later than the pose
  bool noise{true};                             ///< of all readings; the filter is told the same in any case
  std::function<void(double, Pose2&)> disturb;  ///< what a localiser makes of the true pose at a time [s]
};

/// A simulated car, gains (1.02, 0.99, 1.03), that gives a calibration what the messages would.
class CarWithLaser {
 public:
  explicit CarWithLaser(const CarSettings& settings);

  /// Drives on to a time [s] since the beginning.
  void driveUntil(double time, Calibrator& calibrator);

  /// What every further update and pose also goes to, none to end it.
  using UpdateListener = std::function<void(const OdometryUpdate&)>;
  void setListener(UpdateListener listener) { listener_ = std::move(listener); }

  Pose2 truePose() const;
  ParameterVector trueValues() const;

 private:
  void readLaser();
  void deliver(Calibrator& calibrator);

  CarSettings settings_;
  simulation::TrueParameters truth_;
  simulation::SimulatedCar car_;
  OdometryPipeline pipeline_;
  std::deque<std::pair<double, LaserPose>> on_the_way_;  ///< with the time of receipt
  UpdateListener listener_;
  int next_step_{0};
};

/// A scenario by its name, or of one's own.
simulation::Scenario scenarioNamed(const std::string& name);
simulation::Scenario scenarioOf(double period, const std::function<simulation::Command(double)>& pattern);

}  // namespace bs_car_odometry::calibration
