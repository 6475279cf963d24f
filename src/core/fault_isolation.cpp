#include "bs_car_odometry/core/fault_isolation.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

namespace {

/// Fall of chi-square from which a fault is believed: 6.7 standard deviations, 2e-11. Six hypotheses ten
/// times a second make one false alarm in some 20 years.
constexpr double kAlarm = 45.0;
/// The fault must explain so much of the contradiction: what a car's model leaves out is spread over all.
constexpr double kExplained = 0.5;
/// What is left of chi-square under another hypothesis must be so many times as much to rule it out.
constexpr double kSeparation = 2.0;
constexpr double kDegreesOfFreedom = 3.0;  // of six equations; what is left of chi-square in any case

constexpr double kLeastTravel = 0.02;  // of a wheel's travel,
constexpr double kLeastSlip = 0.01;    // [m] and of it: speeds below which a driver reads zero
constexpr double kLeastAngle = 0.03;   // [rad]

constexpr std::array<systematic::Index, kSensors> kParameterOf{
    systematic::kFrontLeft, systematic::kFrontRight,  systematic::kRearLeft,
    systematic::kRearRight, systematic::kFrontOffset, systematic::kRearOffset};

}  // namespace

double leastFault(std::size_t sensor) { return isWheel(sensor) ? kLeastTravel : kLeastAngle; }

SensorTests testSensors(const ParameterEvidence& evidence, const SystematicCovariance& prior) {
  const SystematicCovariance& N = evidence.information;
  const Eigen::PartialPivLU<SystematicCovariance> allowing(SystematicCovariance::Identity() + N * prior);
  const ParameterEvidence::Gradient score = allowing.solve(evidence.gradient);
  const SystematicCovariance M = allowing.solve(N);
  SensorTests tests;
  tests.chi_square = evidence.chi_square - evidence.gradient.dot(prior * score);
  for (std::size_t i = 0; i < kSensors; ++i) {
    const auto k = static_cast<Eigen::Index>(kParameterOf[i]);
    if (!(M(k, k) > 0.0)) continue;
    SensorTest& test = tests.sensors[i];
    test.deviation = score(k) / M(k, k);
    test.sigma = 1.0 / std::sqrt(M(k, k));
    test.fall = score(k) * test.deviation;
  }
  return tests;
}

Suspects suspects(const SensorTests& tests, double length) {
  const auto left = [&](std::size_t i) {
    return std::max(tests.chi_square - tests.sensors[i].fall, kDegreesOfFreedom);
  };
  std::size_t best = 0;
  for (std::size_t i = 1; i < kSensors; ++i)
    if (tests.sensors[i].fall > tests.sensors[best].fall) best = i;
  Suspects found;
  if (left(best) > (1.0 - kExplained) * tests.chi_square) return found;
  const auto add = [&](std::size_t i) {
    const double least = isWheel(i) ? std::max(leastFault(i), kLeastSlip / length) : leastFault(i);
    if (tests.sensors[i].fall > kAlarm && std::abs(tests.sensors[i].deviation) > least)
      found.sensors[found.count++] = i;
  };
  add(best);
  for (std::size_t i = 0; i < kSensors; ++i)
    if (i != best && left(i) <= kSeparation * left(best)) add(i);
  return found;
}

}  // namespace bs_car_odometry
