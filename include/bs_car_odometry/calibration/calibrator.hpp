#pragma once

#include "bs_car_odometry/calibration/excitation.hpp"
#include "bs_car_odometry/calibration/filter.hpp"
#include "bs_car_odometry/calibration/rehearsal.hpp"

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace bs_car_odometry::calibration {

/// What became of a laser pose when it came (docs/reliability.md). Those after kOverflow are found where
/// messages enter.
enum class LaserVerdict {
  kAccepted,
  kNotFinite,
  kBadCovariance,
  kOutOfOrder,
  kTooLate,
  kOverflow,
  kStampZero,
  kStampInvalid,  ///< nanoseconds out of range
  kFuture,
  kOtherFrame,  ///< in another map than the poses before
  kNoMount,     ///< where the laser sits is not known yet
  kCount
};

enum class CalibrationStage { kStart, kRunning, kConverged };

struct LaserCounts {
  std::uint64_t used{0};      ///< poses that updated the filter
  std::uint64_t rejected{0};  ///< of these, beyond kRejectLimit
  std::uint64_t relocalisations{0};
  std::uint64_t dropped{0};  ///< not even looked at: verdicts other than kAccepted
};

/// What is left of a calibration when its program ends, and can be gone on with: everything but the pose.
struct CalibrationMemory {
  ParameterVector values{ParameterVector::Zero()};
  ParameterMatrix covariance{ParameterMatrix::Zero()};
  Excitation driven;
  LaserCounts counts;
  TimeSpan span{};
};

/// The localiser's map has moved under the car (docs/reliability.md, row C4).
struct LocaliserJump {
  Time stamp;            ///< of the first laser pose from the new place
  double distance{0.0};  ///< [m] by which base_link is elsewhere than the wheels say
  double turn{0.0};      ///< [rad], within +/- pi
};

/// One update of the filter, for plots and messages.
struct CalibrationUpdate {
  Time stamp;  ///< of the laser pose
  Time seen;   ///< when the car was there, by the wheels' clock: what the estimate is of
  LaserPose laser;
  Innovation innovation;
  FilterEstimate estimate;
  double distance{0.0};               ///< [m] since the beginning
  std::optional<LocaliserJump> jump;  ///< one that was followed with this update
};

/// The calibration over time: brings laser poses and steps together in order of stamps, whatever the order in
/// which they come, finds a first fix, notices when the localiser jumps, and says how far it has come
/// (docs/calibration.md, 3). Live and bag both drive this class with the updates of an OdometryPipeline:
///     calibrator.add(update); calibrator.add(laser); ...
/// Not thread safe.
class Calibrator {
 public:
  explicit Calibrator(const Parameters& parameters);

  /// The next step of the odometry.
  void add(const OdometryUpdate& update);

  /// A laser pose whose covariance is positive definite, at most kLongestDelay late.
  LaserVerdict add(const LaserPose& laser);

  /// Begins anew: parameters at their prior, pose unknown.
  void start();

  /// Another drive of the same car, or another time: what has been learnt of the parameters stays.
  void newDrive();

  /// None before the first fix, and where the filter knows more than this holds (Filter::restore).
  std::optional<CalibrationMemory> memory() const;
  /// Goes on with what was learnt of the parameters; to be called before anything is added.
  /// @return false when the filter cannot
  bool resume(const CalibrationMemory& memory);

  /// See Filter, for `calibration/method: paper`; after start() or newDrive(). Several drives: stage 1 lasts
  /// for the first one.
  void setStraightRun(bool lasts) { filter_->setStraightRun(lasts); }
  void takeTapedRun(const std::vector<MeasuredStep>& run, double distance) {
    filter_->takeTapedRun(run, distance);
  }

  /// Called after each update of the filter.
  void setListener(std::function<void(const CalibrationUpdate&)> listener) {
    listener_ = std::move(listener);
  }

  CalibrationStage stage() const;
  FilterEstimate estimate() const { return filter_->estimate(); }
  const Innovation& innovation() const { return innovation_; }
  const LaserCounts& counts() const { return counts_; }
  const Excitation& excitation() const { return excitation_; }
  const ParameterMask& estimated() const { return estimated_; }
  const ParameterVector& prior() const { return prior_; }
  /// Estimated ones whose standard deviation is below half of its prior.
  ParameterMask observed() const;
  /// True when every gain that is estimated is observed.
  bool allGainsObserved() const;
  /// The stamps that the calibration has gone through; none before the first fix.
  const std::optional<TimeSpan>& span() const { return span_; }

  /// A late pose is taken at its own stamp for so long.
  static constexpr Duration kLongestDelay = std::chrono::seconds(2);

 private:
  struct Fix {
    LaserPose laser;
    std::vector<MeasuredStep> steps;  ///< from the fix before to this one
  };

  void process();
  void drop();
  void moveTo(Time time);
  void move(const MeasuredStep& step);
  void consumeOldSteps();
  void forgetPose();
  void forgetTime();
  void take(const LaserPose& laser);
  void collectFix(const LaserPose& laser);
  void begin(std::size_t chosen, const std::vector<Pose2>& motions);
  void update(const LaserPose& laser);
  std::optional<LocaliserJump> watchForJump(const LaserPose& laser, double lead,
                                            std::unique_ptr<Filter> before);
  LocaliserJump adoptCandidate();
  void rehearse();
  void report(const LaserPose& laser, const std::optional<LocaliserJump>& jump);
  Time effectiveTime(const LaserPose& laser) const;

  Parameters parameters_;
  ParameterMask estimated_;
  ParameterVector prior_;
  std::unique_ptr<Filter> filter_;
  std::optional<Rehearsal> rehearsal_;   ///< while the drive is young
  std::unique_ptr<Filter> before_jump_;  ///< while poses are rejected: without them,
  std::unique_ptr<Filter> candidate_;    ///< and begun anew at the first of those that agree
  Time candidate_begin_;                 ///< stamp of that one
  int agreeing_{0};                      ///< poses that the candidate has taken

  std::deque<MeasuredStep> steps_;    ///< not yet gone through, in order and without a break
  std::deque<LaserPose> lasers_;      ///< waiting, in order of stamps
  std::optional<Time> now_;           ///< how far the filter has come
  std::optional<Time> newest_laser_;  ///< stamp of the last one that was taken on
  std::vector<Fix> fixes_;            ///< the first poses, from which the beginning is chosen
  std::vector<MeasuredStep> since_fix_;
  bool begun_{false};       ///< the filter has a pose
  bool ever_begun_{false};  ///< and had one before, since the start

  Innovation innovation_;
  LaserCounts counts_;
  Excitation excitation_;
  std::optional<TimeSpan> span_;
  std::function<void(const CalibrationUpdate&)> listener_;
};

}  // namespace bs_car_odometry::calibration
