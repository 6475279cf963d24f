#include "simulated_run.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <iostream>

namespace bs_car_odometry::tools::testing {

namespace {

/// Sorts a simulated message into a drive.
struct Recorder {
  RecordedDrive& drive;
  const SimulatedMessage& message;
  bool laser;

  void operator()(const WheelTicks& ticks) const { drive.inputs.push_back({toRos(message.receipt), ticks}); }
  void operator()(const SteeringAngle& angle) const {
    const Axle axle = message.topic == "front_steering" ? Axle::kFront : Axle::kRear;
    drive.inputs.push_back({toRos(message.receipt), AxleReading{axle, angle}});
  }
  void operator()(const nav_msgs::Odometry& truth) const {
    if (!laser) drive.truth.push_back({*toTime(truth.header.stamp), *toPose(truth.pose.pose)});
  }
  void operator()(const geometry_msgs::PoseWithCovarianceStamped& pose) const {
    if (laser) drive.truth.push_back({*toTime(pose.header.stamp), *toPose(pose.pose.pose)});
  }
  void operator()(const tf2_msgs::TFMessage& /*mount*/) const {}
};

}  // namespace

Parameters cycab(AxleSelection axles) {
  Parameters parameters;
  parameters.vehicle.wheelbase = 1.2;
  parameters.vehicle.track = {1.2, 1.2};
  parameters.vehicle.metres_per_tick = {{1e-6, 1e-6, 1e-6, 1e-6}};
  parameters.odometry.axles = axles;
  return parameters;
}

RecordedDrive simulate(const Parameters& parameters, const SimulatedDriveSettings& settings, bool laser) {
  SimulatedDrive simulated(parameters, settings, Time(durationFromSeconds(1.6e9)));
  RecordedDrive drive;
  drive.name = settings.scenario + " " + std::to_string(settings.seed);
  if (laser) drive.tracked_point = {parameters.laser.x, parameters.laser.y, parameters.laser.yaw};
  while (const auto message = simulated.next())
    std::visit(Recorder{drive, *message, laser}, message->content);
  return drive;
}

std::vector<RecordedRun> simulatedRuns(const Parameters& parameters, SimulatedDriveSettings settings,
                                       std::uint64_t first_seed, std::size_t count) {
  std::cout << "seeds " << first_seed << " to " << first_seed + count - 1 << "\n";
  std::vector<RecordedRun> runs;
  for (std::size_t i = 0; i < count; ++i) {
    settings.seed = first_seed + i;
    runs.push_back({simulate(parameters, settings), "", std::to_string(settings.seed)});
  }
  return runs;
}

}  // namespace bs_car_odometry::tools::testing
