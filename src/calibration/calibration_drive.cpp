#include "bs_car_odometry/calibration/calibration_drive.hpp"

#include <algorithm>

namespace bs_car_odometry::calibration {

namespace {

std::array<float, kAxles> narrow(double front, double rear) {
  return {static_cast<float>(front), static_cast<float>(rear)};
}

}  // namespace

void CalibrationDrive::add(const MeasuredStep& step) {
  StoredStep stored;
  stored.span = step.span;
  const auto& travel = step.readings.travel.values;
  std::transform(travel.begin(), travel.end(), stored.travel.begin(),
                 [](double metres) { return static_cast<float>(metres); });
  stored.begin = narrow(step.readings.begin.front, step.readings.begin.rear);
  stored.end = narrow(step.readings.end.front, step.readings.end.rear);
  stored.doubt = narrow(step.steering_doubt.front, step.steering_doubt.rear);
  stored.left_out = step.readings.left_out;
  steps_.push_back(stored);
}

MeasuredStep CalibrationDrive::step(std::size_t i) const {
  const StoredStep& stored = steps_[i];
  MeasuredStep step;
  step.span = stored.span;
  std::copy(stored.travel.begin(), stored.travel.end(), step.readings.travel.values.begin());
  step.readings.begin = {stored.begin[0], stored.begin[1]};
  step.readings.end = {stored.end[0], stored.end[1]};
  step.steering_doubt = {stored.doubt[0], stored.doubt[1]};
  step.readings.left_out = stored.left_out;
  return step;
}

void DriveRecorder::add(const CalibrationUpdate& update, const LaserCounts& counts) {
  const bool jumped = counts.relocalisations != relocalisations_;
  relocalisations_ = counts.relocalisations;
  const bool rejected = update.innovation.nis > kRejectLimit;
  drive_.add(DriveLaser{update.laser, update.estimate.pose, jumped, rejected});
}

}  // namespace bs_car_odometry::calibration
