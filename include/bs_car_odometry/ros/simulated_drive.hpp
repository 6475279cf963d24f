#pragma once

#include "bs_car_odometry/SteeringAngle.h"
#include "bs_car_odometry/WheelTicks.h"
#include "bs_car_odometry/core/time.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"
#include "bs_car_odometry/simulation/simulated_car.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <std_msgs/Header.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>

namespace bs_car_odometry {

/// A drive of the simulated car, as asked for on a command line or by private parameters.
struct SimulatedDriveSettings {
  std::string scenario{"fig4"};
  std::uint64_t seed{1};
  double rate{50.0};          ///< [Hz], wheel_ticks and ground_truth
  double steering_rate{0.0};  ///< [Hz], 0: an angle with each wheel message
  double laser_rate{10.0};    ///< [Hz], 0: no laser
  double duration{0.0};       ///< [s], 0: the scenario's; in a longer one its pattern repeats
  double speed_factor{1.0};   ///< multiplies the scenario's speed
  bool noise_free{false};     ///< true gains as configured, exact sensors but for rounding to ticks
  bool draw_gains{false};  ///< true parameters drawn from p(A), instead of (1.02, 0.99, 1.03) times the gains
  bool truth{true};        ///< with ground_truth
};

/// One message of the drive, with its topic and when it would have been received.
struct SimulatedMessage {
  using Content = std::variant<WheelTicks, SteeringAngle, nav_msgs::Odometry,
                               geometry_msgs::PoseWithCovarianceStamped, tf2_msgs::TFMessage>;
  Time receipt;
  std::string topic;  ///< wheel_ticks, front_steering, rear_steering, ground_truth, laser_pose or tf_static
  Content content;
};

/// The messages of a simulated drive in the order of their receipt. Wheels arrive 1 ms after their stamp,
/// angles 2 ms, laser poses 3 ms, so that the odometry has to wait for the angles of its wheels.
class SimulatedDrive {
 public:
  /// @param start stamp of the first messages
  /// @throws std::invalid_argument for settings that make no sense, naming the one
  SimulatedDrive(const Parameters& parameters, const SimulatedDriveSettings& settings, Time start);

  /// The next message; none at the end of the drive.
  std::optional<SimulatedMessage> next();

  double duration() const { return duration_; }  ///< [s]
  const simulation::TrueParameters& truth() const { return truth_; }
  const simulation::SimulatedCar& car() const { return car_; }

 private:
  /// One kind of reading, `rate` times a second from the start on; a rate of 0: never.
  struct Schedule {
    double rate;
    std::int64_t done{0};
    double next() const;
  };

  void readWheels();
  void readSteering(Axle axle);
  void readLaser();
  void sendTruth();
  void sendLaserMount();
  std_msgs::Header header(double time, const std::string& frame) const;
  Time stamp(double time) const { return start_ + durationFromSeconds(time); }
  void send(double receipt, const std::string& topic, SimulatedMessage::Content content);

  Parameters parameters_;
  SimulatedDriveSettings settings_;
  Time start_;
  simulation::Drivetrain drivetrain_;
  simulation::TrueParameters truth_;
  double duration_;
  simulation::SimulatedCar car_;
  Schedule wheels_;
  Schedule steering_;
  Schedule laser_;
  std::multimap<Time, SimulatedMessage> pending_;  ///< by receipt
};

/// Gains and steering of the car as YAML, as they would stand in a vehicle file.
std::string describe(const simulation::TrueParameters& truth);

}  // namespace bs_car_odometry
