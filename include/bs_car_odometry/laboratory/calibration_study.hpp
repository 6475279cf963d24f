#pragma once

#include "bs_car_odometry/laboratory/calibration_drive.hpp"
#include "bs_car_odometry/laboratory/chi_square.hpp"

#include <functional>
#include <string>
#include <vector>

namespace bs_car_odometry::laboratory {

/// One kind of calibration, over many drives.
struct CalibrationCase {
  std::string scenario{"fig4"};
  AxleSelection axles{AxleSelection::kBoth};
  TrueGains gains;
  double prior{0.02};  ///< of each gain
  std::vector<std::string> estimate{"gains"};
  LaserErrors laser;
  bool noise{true};            ///< of encoders and steering
  double believed_noise{1.0};  ///< what the calibration takes them for, in units of the configured noise
  double settled{0.0};         ///< [m] from where on the errors along the drive are judged
  std::string loop;            ///< scenario driven by dead reckoning afterwards; empty: none
};

/// A car that dead reckons with what a calibration has found, at some places of its way.
struct LoopOutcome {
  double nees{0.0};      ///< of the pose, (N1)
  double distance{0.0};  ///< [m]
  double error{0.0};     ///< of the position [m]
};

/// What a calibration has come to, where the truth is known.
struct CalibrationOutcome {
  calibration::FilterEstimate estimate;
  calibration::ParameterVector error{calibration::ParameterVector::Zero()};  ///< estimate less truth
  double gain_nees{0.0};                                                     ///< of the estimated parameters
  double state_nees{0.0};        ///< of pose and parameters together
  double mean_nis{0.0};          ///< of the laser poses
  double worst_second_nis{0.0};  ///< largest mean over one second of them
  std::size_t updates{0};
  calibration::ParameterMask observed{};
  std::uint64_t relocalisations{0};
  calibration::ParameterVector worst{
      calibration::ParameterVector::Zero()};  ///< |error| over bound, once settled
  calibration::ParameterVector settled_deviation{calibration::ParameterVector::Zero()};
  std::vector<LoopOutcome> loop;
};

/// All drives of a case.
struct CalibrationResult {
  CalibrationCase what;
  std::vector<std::size_t> estimated;  ///< parameters
  calibration::ParameterVector bound;  ///< of standard deviations, at the end of the drive
  std::vector<CalibrationOutcome> runs;

  /// Root mean square error over the bound.
  double ratio(std::size_t parameter) const;
  double worstRatio() const;
  /// |mean error| over the bound, of the parameter where it is largest.
  double worstBias() const;
  /// Mean over the drives.
  double mean(const std::function<double(const CalibrationOutcome&)>& value) const;
  std::size_t count(const std::function<bool(const CalibrationOutcome&)>& holds) const;
  /// Mean over all laser poses.
  double meanNis() const;
  /// True where a parameter is further off than `bounds` bounds.
  bool isLost(const CalibrationOutcome& run, double bounds) const;
};

/// A drive with a second whose mean NIS is larger than in all but one of 1,000 drives that the noise model
/// describes: something is not as it says.
bool isFlagged(const CalibrationOutcome& run);

struct CalibrationStudySettings {
  Parameters configured;
  std::vector<CalibrationCase> cases;
  std::size_t runs{200};
  std::uint64_t seed{1};  ///< of the first drive; each has the next
  unsigned threads{0};
  std::function<void(std::size_t runs)> progress;
};

/// Runs every case over drives of their own seeds; cases that drive alike share the drives. The same on any
/// number of threads.
std::vector<CalibrationResult> studyCalibration(const CalibrationStudySettings& settings);

}  // namespace bs_car_odometry::laboratory
