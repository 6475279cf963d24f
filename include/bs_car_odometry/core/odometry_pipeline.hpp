#pragma once

#include "bs_car_odometry/core/fault_monitor.hpp"
#include "bs_car_odometry/core/motion_history.hpp"
#include "bs_car_odometry/core/odometry_estimator.hpp"
#include "bs_car_odometry/core/steering_buffer.hpp"
#include "bs_car_odometry/core/time.hpp"
#include "bs_car_odometry/core/wheels_and_axles.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace bs_car_odometry {

/// What became of a message (docs/reliability.md).
enum class Verdict {
  kAccepted,
  kStampZero,
  kStampInvalid,  ///< nanoseconds out of range
  kRepeated,
  kOutOfOrder,
  kFuture,
  kNotFinite,
  kSteeringLimit,
  kNoSteering,      ///< wheels before any steering angle was known
  kImplausible,     ///< counters further on than max_speed allows
  kOverflow,        ///< too many messages waiting
  kRivalPublisher,  ///< of a second publisher on an input
  kCount
};

/// Wheel counters, all sampled at `stamp`.
struct WheelCounts {
  Time stamp;
  Time receipt;
  PerWheel<std::int64_t> ticks;
};

/// How often something happened since the start or the last reset.
struct InputCounts {
  std::uint64_t wheel_messages{0};
  std::uint64_t steering_messages{0};
  std::array<std::uint64_t, static_cast<std::size_t>(Verdict::kCount)> verdicts{};
  std::uint64_t steering_held{0};       ///< steps on the last reading, no newer one having come in time
  std::uint64_t counter_restarts{0};    ///< counters taken as a new reference
  std::uint64_t gaps{0};                ///< intervals longer than max_gap
  std::uint64_t wheel_jumps{0};         ///< counters of single wheels that jumped and were left out
  std::uint64_t refused_states{0};      ///< steps undone because the result was not finite or not plausible
  std::uint64_t ambiguous_gaps{0};      ///< gaps in which the counters may have wrapped unseen
  std::uint64_t covariance_repairs{0};  ///< covariances that were not positive semidefinite
  double refused_angle{0.0};            ///< [rad], of the newest message dropped as kSteeringLimit
  Duration ahead{0};  ///< how far the newest message dropped as kFuture was ahead of the clock

  std::uint64_t operator[](Verdict verdict) const { return verdicts[static_cast<std::size_t>(verdict)]; }
};

enum class OdometryState { kNominal, kDegraded, kNoSteering };

/// What one step used and doubted.
struct StepReport {
  OdometryState state{OdometryState::kNominal};
  double interval{0.0};  ///< [s] since the wheel message before, 0 where there is none
  double step{0.0};      ///< [m] path length of base_link, negative in reverse
  PerWheel<bool> wheel_used;
  PerWheel<double> wheel_travel;  ///< [m]
  FitResiduals residuals;
  SensorReport sensors;            ///< what was left out, and why
  PerAxle<double> steering_angle;  ///< [rad] mean over the step
  PerAxle<double> steering_age;    ///< [s]
  double distance{0.0};            ///< [m] since the start or reset
  std::optional<PoseQuantiles> quantiles;
  InputCounts counts;
};

/// The readings between two accepted wheel messages, as the odometry used them.
struct MeasuredStep {
  TimeSpan span;  ///< stamps of the wheel messages
  StepReadings readings;
  PerAxle<double> steering_doubt;  ///< standard deviation of each sensor's angle [rad] beyond its noise
};

struct OdometryUpdate {
  Time stamp;      ///< of the wheel message
  Time completed;  ///< receipt of the message that completed it, or the end of its wait
  OdometryEstimate estimate;
  StepReport report;
  /// How the car came here. None, or a beginning after the stamp before: what lies between was not seen.
  std::optional<MeasuredStep> step;
};

/// From received readings to odometry: checks every message, puts readings in order, brings the steering to
/// the encoders' time, waits for it within bounds, and steps the estimator. One update for each accepted
/// wheel message.
///
/// Live and replay both drive this class, with `now` and receipt times from the ROS clock or from the bag:
///     pipeline.addSteering(...) or pipeline.addWheels(...);
///     while (const auto update = pipeline.next(now)) publish(*update);
/// and again no later than at deadline(). Not thread safe.
class OdometryPipeline {
 public:
  explicit OdometryPipeline(const OdometryConfiguration& configuration);

  /// @param reading  raw angle of the axle's sensor [rad]
  Verdict addSteering(Axle axle, Time stamp, Time receipt, double reading);
  Verdict addWheels(const WheelCounts& counts);
  /// Counts a message that was turned down before it got here, and says so.
  Verdict reject(Verdict verdict);

  /// The next update that is complete at `now`, if any.
  std::optional<OdometryUpdate> next(Time now);

  /// When the oldest waiting wheel message gives up its wait; none when nothing waits.
  std::optional<Time> deadline() const;

  /// Back to the initial pose and covariance; the next wheel message is the first one. Steering stays known.
  void reset();

  /// A new run: everything as at the start (a bag that loops).
  void restart();

  /// The clock went back: readings in the old time are forgotten, pose and counters stay.
  void rebaseTime();

  /// Puts the car at a pose of base_link in odom; distance and counts go on.
  void setPose(const Pose2& pose, const Eigen::Matrix3d& covariance);

  /// Goes on with other values of the parameters, without a jump of pose or covariance: they hold for what
  /// has been read since the last update and has not moved the car yet.
  void setCalibration(const OdometryCalibration& calibration);
  /// What is in use.
  OdometryCalibration calibration() const;

  /// The motion of base_link between stamps of the latest steps. reset(), restart() and rebaseTime() cut it;
  /// setPose() does not, since it moves the pose and not the car.
  const MotionHistory& motionHistory() const { return motion_history_; }

  const InputCounts& counts() const { return counts_; }
  /// As of the last update.
  const PoseUncertainty& uncertainty() const { return estimator_.uncertainty(); }
  const PerAxle<bool>& steeringNeeded() const { return steering_needed_; }
  const PerWheel<bool>& wheelUsed() const { return wheel_used_; }
  bool hasSteering(Axle axle) const { return !steering_[axle].empty(); }
  /// True once a wheel message has given the initial pose.
  bool started() const { return reference_.has_value(); }

 private:
  void forgetTime();
  Verdict checkStamp(Time stamp, Time receipt);
  Verdict count(Verdict verdict);
  bool steeringReaches(Time stamp) const;
  bool steeringKnown() const;
  bool steeringReachesBack(Time stamp) const;
  std::optional<OdometryUpdate> process(const WheelCounts& counts, Time completed);
  PerWheel<double> travels(const WheelCounts& from, const WheelCounts& to) const;
  PerWheel<bool> jumps(const WheelCounts& from, const WheelCounts& to, Duration interval) const;
  bool isPlausible(Duration interval) const;
  bool takeReference(const WheelCounts& counts);
  bool isAmbiguous(Duration interval) const;
  void takeAnew(const WheelCounts& counts);
  std::optional<TimeSpan> spanUntil(const WheelCounts& counts) const;
  std::optional<Duration> noteInterval(const std::optional<TimeSpan>& span);
  void move(const WheelCounts& counts);
  StepReadings read(const StepReadings& measured, bool seen);
  Eigen::Matrix3d watch(const StepReadings& measured, std::optional<Duration> interval);
  void leaveOutJumps(StepReadings& readings);
  StepReadings readingsUntil(const WheelCounts& counts);
  Eigen::Vector3d bendPath(const StepReadings& readings, const PerAxle<double>& doubt);
  void rememberStep(const TimeSpan& span, bool twist_known, const PerAxle<double>& doubt,
                    const Eigen::Matrix3d& unforeseen);
  void rememberUnseen(const TimeSpan& span);
  void reportStep(const StepReadings& measured, const PerWheel<bool>& left_out);
  PerAxle<double> steeringReadingsAt(Time stamp) const;
  SteeringAngles anglesOf(const PerAxle<double>& readings) const;
  PerAxle<double> steeringAges(Time stamp) const;
  PerAxle<double> steeringDoubt(double interval) const;
  OdometryUpdate update(const WheelCounts& counts, Time completed);

  OdometryConfiguration configuration_;
  PerAxle<bool> steering_needed_;
  PerWheel<bool> wheel_used_;
  OdometryEstimator estimator_;
  FaultMonitor monitor_;
  MotionHistory motion_history_;
  PerAxle<SteeringBuffer> steering_;
  std::vector<WheelCounts> waiting_;       ///< in order of stamps
  std::optional<WheelCounts> reference_;   ///< counters at the present pose
  std::optional<WheelCounts> suspicious_;  ///< implausible counters, a restart if the next ones follow them
  PerWheel<bool> jumped_;                  ///< in the message that is being processed,
  PerWheel<bool> jumped_before_;           ///< and in that of the reference
  std::optional<Time> newest_wheels_;
  bool reference_time_known_{false};  ///< false after rebaseTime: the interval from reference_ is unknown
  PerAxle<double> last_readings_;     ///< of the steering at the reference [rad], before scale and offset
  StepReport report_;
  std::optional<MeasuredStep> step_;
  InputCounts counts_;
};

}  // namespace bs_car_odometry
