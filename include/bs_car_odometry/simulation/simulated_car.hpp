#pragma once

#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/core/vehicle.hpp"
#include "bs_car_odometry/simulation/correlated_error.hpp"
#include "bs_car_odometry/simulation/scenario.hpp"
#include "bs_car_odometry/simulation/true_motion.hpp"
#include "bs_car_odometry/simulation/true_parameters.hpp"
#include "bs_car_odometry/simulation/wheel_encoder.hpp"

#include <array>
#include <cstdint>
#include <optional>

namespace bs_car_odometry::simulation {

struct SimulationOptions {
  std::uint64_t seed{1};
  /// [s], far finer than the messages. Over every scenario the noise-free truth of a car of 1.2 m is exact to
  /// 4e-10 of the distance with 0.005, to 2e-9 with 0.01, which is twice as fast.
  double substep{0.005};
  Drivetrain drivetrain{Drivetrain::kSteered};
  Pose initial_pose;  ///< of base_link in odom
  PerWheel<std::int64_t> counter_start;
};

/// A car that drives a scenario, and its sensors. It shares the structs of the vehicle with the odometry but
/// none of its equations, so that it can find mistakes in them. Times are seconds since the start of the
/// drive.
///
///   SimulatedCar car(vehicle, withScenarioGains(vehicle), noise, makeScenario("fig4", vehicle));
///   for (int i = 1; i <= 750; ++i) { car.advanceTo(0.02 * i); odometry.add(car.readCounters(), ...); }
///
/// The same seed, options and readings give the same drive, bit for bit with one libm; the truth does not
/// depend on the readings at all, nor one sensor on how often another is read.
class SimulatedCar {
 public:
  /// @param noise none: the sensors are exact but for rounding, and nothing slips
  SimulatedCar(const Vehicle& vehicle, const TrueParameters& truth, const std::optional<NoiseModel>& noise,
               const Scenario& scenario, const SimulationOptions& options = {});

  /// @throws std::invalid_argument when `time` lies in the past
  void advanceTo(double time) { motion_.advanceTo(time); }
  double time() const { return motion_.time(); }

  /// Counters now; a reading adds the noise of the travel since the one before.
  PerWheel<std::int64_t> readCounters();

  /// Raw reading of the axle's steering sensor [rad], before scale and offset: true angle plus the mean error
  /// over the travel since the reading before.
  double readSteering(Axle axle);

  /// Pose of the laser's point in the map, p_base + R(yaw) (x, y) and yaw + mount yaw, with independent
  /// errors.
  /// @param mount pose of the laser in base_link  @param sigma_position [m]  @param sigma_yaw [rad]
  Pose readLaser(const Pose& mount, double sigma_position, double sigma_yaw);

  const Pose& truePose() const { return motion_.pose(); }
  Twist trueTwist() const { return motion_.twist(); }
  double trueAngle(Axle axle) const { return motion_.angle(axle); }
  double trueTravel(Wheel wheel) const { return motion_.travel(wheel); }

  /// Travel with its noise at the last reading, before it is rounded to ticks [m].
  double measuredTravel(Wheel wheel) const { return encoders_[index(wheel)].measuredTravel(); }

 private:
  /// One axle's angle sensor: its true scale and offset, its error, and the wheels' travel at the last
  /// reading.
  struct SteeringSensor {
    SteeringCalibration calibration;
    CorrelatedError error;
    double left_travel{0.0};
    double right_travel{0.0};
  };

  SteeringSensor& sensor(Axle axle) { return axle == Axle::kFront ? front_sensor_ : rear_sensor_; }

  TrueMotion motion_;
  std::array<WheelEncoder, kWheels> encoders_;
  SteeringSensor front_sensor_;
  SteeringSensor rear_sensor_;
  Random laser_random_;
};

}  // namespace bs_car_odometry::simulation
