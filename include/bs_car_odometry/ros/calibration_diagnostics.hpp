#pragma once

#include "bs_car_odometry/calibration/filter.hpp"
#include "bs_car_odometry/ros/calibration_adapter.hpp"
#include "bs_car_odometry/ros/master_watch.hpp"

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/ros.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

namespace bs_car_odometry {

/// The latest 100 laser poses: do they agree with the noise levels that are configured?
class InnovationMonitor {
 public:
  static constexpr std::size_t kPoses = 100;
  /// Where the mean of 100 chi-square variables with 3 degrees of freedom lies with 99.9 % probability.
  static constexpr double kLeastMean = 2.26;
  static constexpr double kLargestMean = 3.87;
  static constexpr double kMostRejected = 0.1;

  void add(const calibration::Innovation& innovation);
  void clear() { count_ = 0; }

  /// What is wrong, with the remedy; empty when nothing is, or fewer poses than that have come.
  std::string verdict() const;
  /// Mean NIS of those poses that were not rejected.
  double mean() const;

 private:
  std::size_t rejected() const;
  std::ptrdiff_t filled() const { return static_cast<std::ptrdiff_t>(std::min(count_, kPoses)); }

  std::array<double, kPoses> nis_{};
  std::size_t count_{0};
};

/// `/diagnostics` of the calibration at 1 Hz: Calibration, Laser (docs/calibration.md, 3). What is reported
/// is what happened since the report before; every sentence names the remedy.
class CalibrationDiagnostics {
 public:
  CalibrationDiagnostics(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                         const CalibrationAdapter& adapter);

  /// Notes that a message was received.
  void noteWheels() { newest_wheels_ = ros::SteadyTime::now(); }
  void noteLaser() { newest_laser_ = ros::SteadyTime::now(); }
  void note(const calibration::CalibrationUpdate& update);
  void noteStart();
  /// What keeps the result from being written; empty when nothing does.
  void noteOutput(std::string fault) { output_fault_ = std::move(fault); }

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;

  void report();
  void calibration(Status& status);
  void laser(Status& status);
  void addProgress(Status& status) const;
  void addDrops(Status& status) const;

  const CalibrationAdapter& adapter_;
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
  ros::SteadyTime newest_wheels_;
  ros::SteadyTime newest_laser_;
  InnovationMonitor innovations_;
  LaserInputCounts reported_;
  std::string output_fault_;
  std::string jump_;  ///< the latest one of the localiser
  bool jump_reported_{true};
  MasterWatch master_;
};

}  // namespace bs_car_odometry
