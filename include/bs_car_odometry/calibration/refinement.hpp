#pragma once

#include "bs_car_odometry/calibration/calibrated_parameters.hpp"
#include "bs_car_odometry/calibration/calibration_drive.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <vector>

namespace bs_car_odometry::calibration {

/// The drives of a fit. They must outlive it.
using Drives = std::vector<const CalibrationDrive*>;

/// Standard deviations of laser poses over those that they came with.
struct LaserScales {
  double position{1.0};
  double yaw{1.0};
};

/// What a fit makes as small as it can (docs/calibration.md, 4.1 and 4.5).
enum class Objective {
  kLikelihood,  ///< what the noise model finds unlikely: the smallest errors of the gains where it holds
  kPath,        ///< the drift of dead reckoning, from whatever causes: least squares of the positions
};

struct RefinementOptions {
  Objective objective{Objective::kLikelihood};
  std::optional<ParameterVector> seed;  ///< where to begin; none: at the configured values
  LaserScales laser_scales;
  std::size_t most_poses{40000};  ///< of longer drives, every second, third ... laser pose is used
};

/// What a fit leaves over at one laser pose.
struct LaserResidual {
  std::size_t laser;         ///< its number in the drive
  Pose2 pose;                ///< base_link in the map, as fitted
  Eigen::Vector3d residual;  ///< measured less fitted (x, y, yaw) [m, m, rad], yaw wrapped
  double square;             ///< r^T R^-1 r
  double weight;             ///< below 1 where the pose was believed less than its R
};

/// Parameters and the pose at every laser stamp, fitted together (docs/calibration.md, C20 to C24). With
/// Objective::kPath values and covariance are those of (C29), (C30); what is not observed keeps its prior,
/// and the residuals stay those of the likelihood.
struct Refinement {
  ParameterVector values{ParameterVector::Zero()};
  ParameterMatrix covariance{ParameterMatrix::Zero()};  ///< zero for what is not estimated
  ParameterMask estimated{};
  ParameterMask at_bound{};  ///< gains and scales that would go beyond [kLeastGain, kLargestGain]
  /// False when the rounds or the iterations ran out, when a value stopped at its bound, or when no drive has
  /// two laser poses that motion joins.
  bool converged{false};
  double cost{0.0};                                   ///< half the sum of the squares, (C20)
  int rounds{0};                                      ///< linearisations of the motion
  int iterations{0};                                  ///< steps of the solver, of all rounds
  std::vector<std::vector<LaserResidual>> residuals;  ///< for each drive, in order of stamps
};

constexpr double kLeastGain = 0.5;
constexpr double kLargestGain = 2.0;

/// Fits the parameters that `parameters` asks for to all drives together; the gains stay the same over them,
/// whatever `calibration/gain_random_walk` says. Prior: the configured values and priorDeviations().
/// @param parameters  those that the drives were recorded with; their noise levels are those of the fit
Refinement refine(const Drives& drives, const Parameters& parameters, const RefinementOptions& options = {});

/// Where the filter and the refinement of one drive differ by more than their standard deviations.
struct Disagreement {
  std::size_t parameter;
  double difference;  ///< refined less filtered, or path less likelihood
  double deviation;   ///< the larger one of the two standard deviations
};

/// Empty when all is well: both have used the same readings, so they differ by far less.
std::vector<Disagreement> disagreements(const FilterEstimate& filter, const Refinement& refined);

/// Where the two objectives differ by more than their standard deviations: drift that is not noise.
std::vector<Disagreement> disagreements(const Refinement& likelihood, const Refinement& path);

}  // namespace bs_car_odometry::calibration
