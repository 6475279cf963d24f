#pragma once

#include "bs_car_odometry/calibration/calibrated_parameters.hpp"
#include "bs_car_odometry/calibration/calibrator.hpp"
#include "bs_car_odometry/calibration/excitation.hpp"

#include <string>

namespace bs_car_odometry::calibration {

/// How far the parameters have come: what a driver must know (docs/calibration.md, 3).
struct Knowledge {
  ParameterMask estimated{};
  ParameterVector prior{ParameterVector::Zero()};      ///< standard deviations before the drive
  ParameterVector deviation{ParameterVector::Zero()};  ///< present ones
  Excitation excitation;

  bool observed(std::size_t parameter) const {
    const auto k = static_cast<Eigen::Index>(parameter);
    return estimated[parameter] && deviation[k] < 0.5 * prior[k];
  }
};

Knowledge knowledgeOf(const Calibrator& calibrator);

/// 0 to 1: of the information that makes a parameter observed, and of the motion without which none of it
/// could be believed, whichever is less. 1 for what is not estimated.
double progress(const Knowledge& knowledge, std::size_t parameter);

/// What to drive so that everything that is estimated becomes observed, one clause for each manoeuvre:
/// "front/k_b, rear/k_b: turn 140 degrees more to the right". Empty when nothing is missing.
std::string missing(const Knowledge& knowledge);

/// Why the gains must not be saved yet: those that are not observed, with what is missing for them. Empty
/// when all of them are observed.
std::string whyNotAllObserved(const Knowledge& knowledge);

/// Names the gains outside 0.8 to 1.2 and what to check: wheel radius or ticks per turn where a wheel's gain
/// is out, the track where only k_b is, units. Empty when all are inside.
/// @param observed  those to look at
std::string implausibleGains(const ParameterVector& values, const ParameterMask& observed);

}  // namespace bs_car_odometry::calibration
