#pragma once

#include "bs_car_odometry/core/first_order_covariance.hpp"
#include "bs_car_odometry/core/odometry_estimator.hpp"
#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/core/vehicle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace bs_car_odometry::test_support {

/// The Cycab of the papers: phi_rear = -phi_front, base_link in the middle.
inline Vehicle cycab() {
  Vehicle vehicle;
  vehicle.name = "cycab";
  vehicle.wheelbase = 1.2;
  vehicle.track = {1.2, 1.2};
  vehicle.base_link_x = 0.6;
  vehicle.metres_per_tick.values.fill(1e-4);
  return vehicle;
}

/// f = 0, base_link at the rear axle.
inline Vehicle ordinaryCar() {
  Vehicle vehicle = cycab();
  vehicle.name = "car";
  vehicle.wheelbase = 2.7;
  vehicle.track = {1.55, 1.55};
  vehicle.base_link_x = 0.0;
  vehicle.rear_steering.coefficients = {0.0};
  return vehicle;
}

/// Nothing the same at both axles: tracks, hub offsets, rear law, place of base_link.
inline Vehicle unequalCar() {
  Vehicle vehicle = cycab();
  vehicle.name = "unequal";
  vehicle.wheelbase = 1.7;
  vehicle.track = {1.1, 1.3};
  vehicle.base_link_x = 0.45;
  vehicle.hub_offset = {0.06, 0.04};
  vehicle.rear_steering.coefficients = {0.01, -0.6, 0.1};
  return vehicle;
}

/// Parallel wheels on each axle, the paper's model A.
inline Vehicle pivotCar() {
  Vehicle vehicle = cycab();
  vehicle.name = "pivot";
  vehicle.axle_geometry = AxleGeometry::kPivot;
  return vehicle;
}

inline std::vector<Vehicle> fourGeometries() { return {cycab(), ordinaryCar(), unequalCar(), pivotCar()}; }

/// The same car with an angle sensor on the rear axle too.
inline Vehicle withMeasuredRear(Vehicle vehicle) {
  vehicle.rear_steering.source = RearSteering::Source::kMeasured;
  return vehicle;
}

/// Front angle and what the rear law makes of it.
inline SteeringAngles slaved(const Vehicle& vehicle, double front) {
  return {front, vehicle.rear_steering.angle(front)};
}

/// Readings of a step in which the car moves by the constant twist that both angles ask for; `travel` is that
/// of base_link along x [m].
inline StepReadings consistentReadings(const Vehicle& vehicle, double travel,
                                       const SteeringAngles& steering) {
  StepReadings readings;
  readings.begin = readings.end = steering;
  readings.travel = wheelSpeeds(vehicle, bodyTwist(vehicle, travel, steering), steering);
  return readings;
}

/// The covariance of an odometry that propagates it to first order.
inline const FirstOrderCovariance& firstOrder(const OdometryEstimator& estimator) {
  return dynamic_cast<const FirstOrderCovariance&>(estimator.uncertainty());
}

/// For the names of tests.
inline std::string methodName(const testing::TestParamInfo<Uncertainty>& info) {
  switch (info.param) {
    case Uncertainty::kFirstOrder:
      return "firstOrder";
    case Uncertainty::kExactMoments:
      return "exactMoments";
    case Uncertainty::kClosedForm:
      return "closedForm";
    case Uncertainty::kPaper2Simplified:
      return "paper2Simplified";
    case Uncertainty::kMonteCarlo:
      return "monteCarlo";
  }
  return "";
}

/// No error of any kind.
inline NoiseModel noNoise() {
  NoiseModel noise;
  noise.wheel = noise.lateral = noise.rear_law = noise.steering.angle = 0.0;
  noise.systematic = {0.0, 0.0, 0.0, 0.0};
  return noise;
}

/// 1e-12 ... 1, two a decade.
inline std::vector<double> logarithmicSweep() {
  std::vector<double> values;
  for (int i = -24; i <= 0; ++i) values.push_back(std::pow(10.0, 0.5 * i));
  return values;
}

/// The sweep, its negatives and zero.
inline std::vector<double> signedSweep() {
  std::vector<double> values{0.0};
  for (const double value : logarithmicSweep()) values.insert(values.end(), {value, -value});
  return values;
}

}  // namespace bs_car_odometry::test_support
