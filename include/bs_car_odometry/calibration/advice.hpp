#pragma once

#include "bs_car_odometry/calibration/calibrated_parameters.hpp"
#include "bs_car_odometry/calibration/excitation.hpp"
#include "bs_car_odometry/calibration/filter.hpp"

#include <string>

namespace bs_car_odometry::calibration {

/// A gain outside these means that something else is wrong (row C7).
constexpr double kLeastPlausibleGain = 0.8;
constexpr double kLargestPlausibleGain = 1.2;

/// What to drive so that the standard deviation of every missing parameter falls below half of its prior, at
/// the pace at which it has fallen so far: "rear/k_b: turn 140 degrees more to the right". Parts with "; "
/// between them, one for parameters that want the same; empty when nothing is missing.
/// @param missing  estimated, but not observed
std::string whatToDrive(const ParameterMask& missing, const FilterEstimate& estimate,
                        const ParameterVector& prior, const Excitation& excitation);

/// Names the gains outside [kLeastPlausibleGain, kLargestPlausibleGain] and what to check: wheel radius or
/// ticks per turn where a wheel's gain is out, the track where only k_b is, units. Empty when all are inside.
/// @param values     of all parameters
/// @param estimated  those to look at
std::string implausibleGains(const ParameterVector& values, const ParameterMask& estimated);

}  // namespace bs_car_odometry::calibration
