#pragma once

#include "calibration_bags.hpp"
#include "dead_reckoning.hpp"

#include "bs_car_odometry/calibration/leave_one_out.hpp"
#include "bs_car_odometry/calibration/noise_levels.hpp"
#include "bs_car_odometry/calibration/observability.hpp"
#include "bs_car_odometry/calibration/refinement.hpp"
#include "bs_car_odometry/calibration/result.hpp"

#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// Dead reckoning over one bag, with the configured and with the found values.
struct BagPaths {
  std::vector<ReckonedPose> before;
  std::vector<ReckonedPose> after;
};

/// All that calibrate_bag finds.
struct Findings {
  FilteredBags filtered;
  std::optional<calibration::NoiseLevels> noise;
  std::optional<calibration::Refinement> refined;
  calibration::Objective objective{calibration::Objective::kLikelihood};  ///< of refined
  std::vector<calibration::LeftOutDrive> left_out;  ///< for each bag, where there are several

  calibration::ParameterVector values{calibration::ParameterVector::Zero()};  ///< refined where there is that
  calibration::ParameterMatrix covariance{calibration::ParameterMatrix::Zero()};
  calibration::ParameterMask observed{};  ///< by these deviations
  std::vector<BagPaths> paths;            ///< of each bag

  double deviation(std::size_t parameter) const;
  const calibration::ParameterMask& estimated() const { return filtered.estimated; }
  /// Estimated, but not observed.
  calibration::ParameterMask notObserved() const;
  calibration::Knowledge knowledge() const;
};

/// The parameters in a mask, or the gains alone, as words.
std::vector<std::string> namesOf(const calibration::ParameterMask& mask, bool gains_only = false);

/// Fits everything once more where it is asked for, and reckons before and after.
/// @throws InputError where a gain is implausible, NoResultError where the fit did not converge
Findings findingsOf(FilteredBags filtered, const CalibrateOptions& options);

/// What a calibration file says of them.
calibration::CalibrationResult resultOf(const Findings& findings);

}  // namespace bs_car_odometry::tools
