#pragma once

#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/ros/master_watch.hpp"

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/ros.h>

#include <string>

namespace bs_car_odometry {

/// `/diagnostics` of the odometry at 1 Hz: Encoders, Steering, Clock, Calibration, Output
/// (docs/reliability.md). What is reported is what happened since the report before; every sentence names the
/// remedy.
class OdometryDiagnostics {
 public:
  OdometryDiagnostics(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                      const OdometryPipeline& pipeline, const std::string& vehicle);

  /// Notes that a wheel message was received.
  void noteWheels() { newest_wheels_ = ros::SteadyTime::now(); }
  /// Says where the gains in use come from, and what is wrong with that.
  void setCalibration(unsigned char level, const std::string& text) {
    calibration_level_ = level;
    calibration_text_ = text;
  }
  void noteUpdate(const OdometryUpdate& update) {
    state_ = update.report.state;
    steering_age_ = update.report.steering_age;
    sensors_ = update.report.sensors;
  }
  /// Notes a message on a topic that another publisher is heard on.
  void noteRivalInput(const std::string& topic) { rival_input_ = topic; }
  /// Notes what was said of another publisher of the transform.
  void noteRivalTransform(const std::string& text) { rival_transform_ = text; }

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;

  void report();
  void encoders(Status& status);
  void steering(Status& status);
  void clock(Status& status);
  void calibration(Status& status);
  void output(Status& status);
  std::uint64_t since(Verdict verdict) const { return pipeline_.counts()[verdict] - reported_[verdict]; }
  /// Merges a level and the sentence of a verdict when it was given since the last report.
  void add(Status& status, unsigned char level, Verdict verdict) const;

  void addFault(Status& status, std::size_t sensor) const;

  const OdometryPipeline& pipeline_;
  diagnostic_updater::Updater updater_;
  std::string started_;  ///< when: a later time than before says that the process was started again
  MasterWatch master_;
  ros::WallTimer timer_;
  ros::SteadyTime newest_wheels_;
  OdometryState state_{OdometryState::kNominal};
  PerAxle<double> steering_age_;  ///< [s]
  std::string rival_input_;
  std::string rival_transform_;
  SensorReport sensors_;
  unsigned char calibration_level_{diagnostic_msgs::DiagnosticStatus::OK};
  std::string calibration_text_{"none: the gains are those of the vehicle file"};
  InputCounts reported_;
};

/// `/diagnostics` of a nodelet that could not start: ERROR with the reason, at 1 Hz.
class FailureReport {
 public:
  FailureReport(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const std::string& reason);

 private:
  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
};

}  // namespace bs_car_odometry
