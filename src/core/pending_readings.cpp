#include "bs_car_odometry/core/pending_readings.hpp"

#include <cmath>

namespace bs_car_odometry {

namespace {

double sum(const PerWheel<double>& travels) {
  double sum = 0.0;
  for (const double travel : travels.values) sum += travel;
  return sum;
}

/// Of a mean angle and its change over the readings, the angle at their beginning (-1) or end (+1).
double angleAt(double mean, double change, double end) { return mean + 0.5 * end * change; }

}  // namespace

void PendingReadings::add(const StepReadings& readings) {
  double length = 0.0;
  for (const Wheel wheel : kAllWheels) {
    travel_[wheel] += readings.travel[wheel];
    length += std::abs(readings.travel[wheel]) / kWheels;
  }
  if (length_ == 0.0) begin_ = readings.begin;
  end_ = readings.end;
  const SteeringAngles mean = readings.mean();
  weighted_.front += length * mean.front;
  weighted_.rear += length * mean.rear;
  length_ += length;
}

bool PendingReadings::isReversedBy(const StepReadings& readings) const {
  return length_ > 0.0 && sum(travel_) * sum(readings.travel) < 0.0;
}

StepReadings PendingReadings::readings() const {
  StepReadings readings;
  readings.travel = travel_;
  const SteeringAngles mean{weighted_.front / length_, weighted_.rear / length_};
  const SteeringAngles change{end_.front - begin_.front, end_.rear - begin_.rear};
  readings.begin = {angleAt(mean.front, change.front, -1.0), angleAt(mean.rear, change.rear, -1.0)};
  readings.end = {angleAt(mean.front, change.front, 1.0), angleAt(mean.rear, change.rear, 1.0)};
  return readings;
}

}  // namespace bs_car_odometry
