#pragma once

#include "bs_car_odometry/calibration/calibrator.hpp"
#include "bs_car_odometry/calibration/filter.hpp"
#include "bs_car_odometry/core/odometry_pipeline.hpp"

#include <array>
#include <cstddef>
#include <deque>

namespace bs_car_odometry::calibration {

/// A laser pose that the calibration has taken.
struct DriveLaser {
  LaserPose laser;
  Pose2 guess;           ///< base_link in the map at that instant, as the filter has it: where a fit begins
  bool jumped{false};    ///< the localiser has jumped since the pose before: no motion joins the two
  bool rejected{false};  ///< by the filter
};

/// The readings and laser poses of one drive, kept for fits that go through them several times. Readings
/// become numbers of single precision, good to 1e-7 of a step: ten hours at 100 Hz with 10 laser poses a
/// second take 0.25 GiB.
class CalibrationDrive {
 public:
  /// @param step  begins at or after the end of the step before; what lies between was not seen
  void add(const MeasuredStep& step);
  /// @param laser  in order of stamps; may come before or after the steps that lead to it
  void add(const DriveLaser& laser) { lasers_.push_back(laser); }

  std::size_t steps() const { return steps_.size(); }
  MeasuredStep step(std::size_t i) const;
  const std::deque<DriveLaser>& lasers() const { return lasers_; }

 private:
  struct StoredStep {
    TimeSpan span;
    std::array<float, kWheels> travel;
    std::array<float, kAxles> begin;
    std::array<float, kAxles> end;
    std::array<float, kAxles> doubt;
    PerWheel<bool> left_out;
  };

  std::deque<StoredStep> steps_;  // not a vector, which needs room for all of them twice when it grows
  std::deque<DriveLaser> lasers_;
};

/// Keeps what a Calibrator takes:
///     calibrator.setListener([&](const CalibrationUpdate& update) { recorder.add(update,
///     calibrator.counts()); }); recorder.add(update); calibrator.add(update);
class DriveRecorder {
 public:
  void add(const OdometryUpdate& update) {
    if (update.step) drive_.add(*update.step);
  }
  /// @param counts  of the calibrator now: tell where the localiser has jumped
  void add(const CalibrationUpdate& update, const LaserCounts& counts);

  const CalibrationDrive& drive() const { return drive_; }
  CalibrationDrive take() { return std::move(drive_); }

 private:
  CalibrationDrive drive_;
  std::uint64_t relocalisations_{0};
};

}  // namespace bs_car_odometry::calibration
