#pragma once

#include "bs_car_odometry/calibration/calibrator.hpp"
#include "bs_car_odometry/ros/laser_input.hpp"
#include "bs_car_odometry/ros/odometry_adapter.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry {

/// What became of the laser poses since the start.
struct LaserInputCounts {
  std::uint64_t messages{0};
  std::uint64_t without_covariance{0};  ///< taken with laser_sigma
  std::array<std::uint64_t, static_cast<std::size_t>(calibration::LaserVerdict::kCount)> verdicts{};

  std::uint64_t operator[](calibration::LaserVerdict verdict) const {
    return verdicts[static_cast<std::size_t>(verdict)];
  }
};

/// The calibration as messages see it: an OdometryAdapter that gives the steps, a Calibrator that takes them
/// and the laser poses. The node and calibrate_bag drive this one class:
///     adapter.add(message, receipt);
///     while (const auto update = adapter.next(now)) ...
/// Not thread safe.
class CalibrationAdapter {
 public:
  using Listener = std::function<void(const calibration::CalibrationUpdate&)>;

  explicit CalibrationAdapter(const Parameters& parameters);

  /// Messages in, with the time of their receipt: the clock live, the record time in a bag.
  Verdict add(const WheelTicks& message, const ros::Time& receipt, const Sender& sender = {});
  Verdict add(Axle axle, const SteeringAngle& message, const ros::Time& receipt, const Sender& sender = {});
  JointVerdicts add(const RawJointState& message, const ros::Time& receipt, const Sender& sender = {});
  calibration::LaserVerdict add(const geometry_msgs::PoseWithCovarianceStamped& message,
                                const ros::Time& receipt);
  /// Ones that were shorter than their lengths claim, whose values are missing.
  Verdict addCut() { return odometry_.addCut(); }
  calibration::LaserVerdict addCutLaser() { return count(calibration::LaserVerdict::kNotFinite); }

  /// A message of /tf or /tf_static; looked at only while laser/frame is searched for.
  void add(const tf2_msgs::TFMessage& message);

  /// The next update that is complete at `now`; the calibration has it already.
  std::optional<OdometryUpdate> next(const ros::Time& now);

  /// When next() must be called again even if no message comes.
  std::optional<ros::Time> deadline() const { return odometry_.deadline(); }

  /// Takes what still waits: this drive is over.
  void finish();

  /// Another drive of the same car: gains go on, pose and map are unknown.
  void newDrive();

  /// Begins anew: parameters at their prior. The odometry goes on.
  void start();

  /// Goes on with what another run has learnt.
  /// @return false when the method cannot
  bool resume(const calibration::CalibrationMemory& memory) { return calibrator_->resume(memory); }

  /// See calibration::Filter; once the mount is known, and after start() or newDrive().
  void setStraightRun(bool lasts) { calibrator_->setStraightRun(lasts); }
  void takeTapedRun(const std::vector<MeasuredStep>& run, double distance) {
    calibrator_->takeTapedRun(run, distance);
  }

  /// The clock went back: with simulated time a new run begins, otherwise the gains go on.
  void clockWentBack(bool simulated_time);

  /// Called after each update of the filter.
  void setListener(Listener listener);

  /// False while laser poses are dropped because tf has not said where the laser sits.
  bool mountKnown() const { return !mount_finder_; }
  /// One sentence on what is waited for, with frames, stamp and wait; empty when the mount is known.
  std::string waitingForMount(const ros::Time& now) const;

  /// Valid until the mount becomes known.
  const calibration::Calibrator& calibrator() const { return *calibrator_; }
  const OdometryPipeline& pipeline() const { return odometry_.pipeline(); }
  /// With the laser's mount in its place.
  const Parameters& parameters() const { return parameters_; }
  const LaserInputCounts& laserCounts() const { return laser_counts_; }
  /// The map's name; empty before the first laser pose.
  const std::string& mapFrame() const { return reader_.mapFrame(); }

 private:
  calibration::LaserVerdict count(calibration::LaserVerdict verdict);
  calibration::LaserVerdict addLaser(const geometry_msgs::PoseWithCovarianceStamped& message,
                                     const ros::Time& receipt);
  void takeMount(const Pose2& mount);
  void makeCalibrator();

  Parameters parameters_;
  OdometryAdapter odometry_;
  LaserPoseReader reader_;
  std::unique_ptr<LaserMountFinder> mount_finder_;  ///< while the mount is unknown
  std::unique_ptr<calibration::Calibrator> calibrator_;
  Listener listener_;
  LaserInputCounts laser_counts_;
  struct Waiting {
    ros::Time stamp;
    ros::Time since;
  };
  std::optional<Waiting> waiting_;  ///< the first laser pose that came without a mount
};

/// One sentence on why a laser pose was dropped, with the remedy; empty for kAccepted.
const char* explain(calibration::LaserVerdict verdict);

/// One sentence on a jump that was followed: how far, when, what became of the calibration, and the remedy.
std::string explain(const calibration::LocaliserJump& jump);

}  // namespace bs_car_odometry
