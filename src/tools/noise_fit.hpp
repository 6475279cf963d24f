#pragma once

#include "drive_errors.hpp"
#include "variance_fit.hpp"

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace bs_car_odometry::tools {

/// Where a drive belongs.
struct RecordedRun {
  RecordedDrive drive;
  std::string wheels;     ///< runs on the same wheels have the same gains
  std::string recording;  ///< runs of one recording share their systematic errors
};

struct NoiseFitSettings {
  ErrorSettings errors;
  std::vector<std::string> noise;  ///< what to find (noiseNames()); empty: what the drives can tell
};

/// A standard deviation of `noise` that was found.
struct FoundNoise {
  std::string name;   ///< path of the parameter
  double value{0.0};  ///< in its unit
  double std{0.0};    ///< standard deviation of the value; 0 where it is 0
};

/// Gains of one set of wheels.
struct FoundGains {
  std::string wheels;
  Eigen::VectorXd value;       ///< in the order of NoiseFit::gain_names
  Eigen::MatrixXd covariance;  ///< of what is common to all recordings
  /// Standard deviations in another drive: what the fit leaves open, and how recordings differ.
  Eigen::VectorXd std_in_next_drive;
};

struct NoiseFit {
  std::vector<FoundNoise> noise;
  std::vector<std::string> gain_names;  ///< paths of the parameters
  std::vector<FoundGains> gains;
  /// `noise/systematic/...` of another drive, with its value: independent errors of the gains that do to the
  /// ends of these drives what the covariances found and the differences between recordings would.
  std::vector<std::pair<std::string, double>> next_drive;
  double log_likelihood{0.0};
  std::size_t runs{0};
  std::size_t recordings{0};
  std::size_t places{0};
  double distance{0.0};  ///< [m]
};

/// Runs linearised about common noise and the gains of their own wheels and recording, and the model of their
/// errors.
class LinearisedRuns {
 public:
  /// @throws InputError
  LinearisedRuns(const std::vector<RecordedRun>& runs, const Parameters& parameters,
                 const NoiseFitSettings& settings);

  /// Linearises again about a result. @param progress  called after each run
  void linearise(const std::function<void()>& progress);

  /// Variances of largest likelihood over the runs that `uses` says.
  VarianceFit fit(const std::function<bool(std::size_t)>& uses) const { return fit(uses, start_); }
  /// The same, with a search that begins near `guess`.
  VarianceFit fit(const std::function<bool(std::size_t)>& uses, const Eigen::VectorXd& guess) const;

  /// Sets noise and gains to a result; the next linearise() is about them.
  void adopt(const VarianceFit& fit);

  /// The model of the runs that `uses` says.
  VarianceComponents model(const std::function<bool(std::size_t)>& uses) const;

  NoiseFit describe(const VarianceFit& fit) const;

  const std::vector<RecordedRun>& runs() const { return runs_; }
  const std::vector<DriveErrors>& errors() const { return errors_; }
  std::size_t wheelsOf(std::size_t run) const { return wheels_of_[run]; }
  std::size_t recordingOf(std::size_t run) const { return recording_of_[run]; }
  std::size_t recordings() const { return recordings_.size(); }

 private:
  std::vector<std::string> defaultNoise() const;
  DriveErrors linearised(std::size_t run) const;
  GainPrior priorOf(std::size_t wheels) const;
  std::vector<std::pair<std::string, double>> nextDrive(const VarianceFit& fit,
                                                        const std::vector<GainEstimate>& gains,
                                                        const Eigen::VectorXd& systematic) const;

  const std::vector<RecordedRun>& runs_;
  Parameters nominal_;
  NoiseFitSettings settings_;
  std::vector<std::string> wheels_;      ///< names, in order of appearance
  std::vector<std::string> recordings_;  ///< likewise
  std::vector<std::size_t> wheels_of_;   ///< of each run
  std::vector<std::size_t> recording_of_;
  NoiseUnknowns unknowns_;
  std::vector<Parameters> parameters_;  ///< in force, for each set of wheels
  std::vector<Eigen::VectorXd> draws_;  ///< of the gains, in force for each recording beside them
  Eigen::VectorXd start_;               ///< variances at which the search begins
  std::vector<DriveErrors> errors_;
};

/// Finds noise and gains by restricted maximum likelihood over whole paths (docs/model.md, 5.9): linearises,
/// fits, and begins again from the result until the gains stand.
/// @throws InputError
NoiseFit fitNoise(const std::vector<RecordedRun>& runs, const Parameters& parameters,
                  const NoiseFitSettings& settings);

/// The last linearisation of fitNoise() with its variances, for those who want to leave runs out.
std::pair<LinearisedRuns, VarianceFit> linearisedFit(const std::vector<RecordedRun>& runs,
                                                     const Parameters& parameters,
                                                     const NoiseFitSettings& settings);

}  // namespace bs_car_odometry::tools
