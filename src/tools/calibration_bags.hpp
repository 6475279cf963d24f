#pragma once

#include "calibrate_options.hpp"

#include "bs_car_odometry/calibration/calibration_drive.hpp"
#include "bs_car_odometry/calibration/calibrator.hpp"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// A bag that has gone through the calibration.
struct CalibratedBag {
  std::string path;
  std::string name() const { return path.substr(path.rfind('/') + 1); }
  calibration::CalibrationDrive drive;
  std::vector<bool> good;         ///< for each laser pose of the drive: not rejected
  std::vector<double> distances;  ///< [m] driven until then, bags before this one included
  double distance{0.0};           ///< [m] since its first laser pose
  std::vector<calibration::LocaliserJump> jumps;
};

/// What the filter has made of all bags together.
struct FilteredBags {
  Parameters parameters;  ///< with the laser's mount from tf
  std::vector<CalibratedBag> bags;
  calibration::FilterEstimate estimate;
  calibration::ParameterMask estimated{};
  calibration::ParameterVector prior{calibration::ParameterVector::Zero()};
  calibration::LaserCounts counts;
  calibration::Excitation excitation;
  TimeSpan span;
  double mean_nis{0.0};  ///< of the poses that were not rejected
};

using CalibrationListener = std::function<void(const calibration::CalibrationUpdate&)>;

/// Runs the filter over the bags, through the class that the node drives; the clock is the bags' record time.
/// @param listener  told of every update of the filter; may be empty
/// With `calibration/method: paper` the first of several bags is stage 1, or, where a tape has measured it, a
/// run that needs no laser.
/// @throws NoResultError after a run by tape alone; InputError when a topic is missing or of another type,
/// the laser's frame is not in tf, or a bag
///         gave no odometry or no beginning; says what was dropped and why
FilteredBags filterBags(const CalibrateOptions& options, const CalibrationListener& listener);

}  // namespace bs_car_odometry::tools
