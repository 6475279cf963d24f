#pragma once

#include "bs_car_odometry/SteeringAngle.h"
#include "bs_car_odometry/WheelTicks.h"
#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/parameters/configuration.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"
#include "bs_car_odometry/ros/calibration_acceptance.hpp"
#include "bs_car_odometry/ros/conversions.hpp"
#include "bs_car_odometry/ros/joint_state_reader.hpp"
#include "bs_car_odometry/ros/publisher_watch.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/time.h>

#include <optional>
#include <string>

namespace bs_car_odometry {

constexpr double kFarthestJoint = 1e9;  ///< [rad]; beyond, a wheel joint's counter would leave its 64 bits

/// What became of a joint state: of its steering joints, and of its wheels where it holds them.
struct JointVerdicts {
  Verdict steering{Verdict::kAccepted};
  std::optional<Verdict> wheels;

  /// The first refusal, of the wheels before the steering.
  Verdict worst() const { return wheels && *wheels != Verdict::kAccepted ? *wheels : steering; }
};

/// The odometry as messages see it: turns them into readings, and keeps the clock. The nodelet and replay_bag
/// drive this one class, so that what is measured offline is what drives.
class OdometryAdapter {
 public:
  explicit OdometryAdapter(const Parameters& parameters);

  /// Messages in, with the time of their receipt: the clock live, the record time in a bag. Each input is
  /// kept to its first publisher; joint states are an input of the wheels and one of each axle's steering.
  Verdict add(const WheelTicks& message, const ros::Time& receipt, const Sender& sender = {});
  Verdict add(Axle axle, const SteeringAngle& message, const ros::Time& receipt, const Sender& sender = {});
  JointVerdicts add(const RawJointState& message, const ros::Time& receipt, const Sender& sender = {});
  /// One that was shorter than its lengths claim, whose value is missing.
  Verdict addCut() { return pipeline_.reject(Verdict::kNotFinite); }

  /// The next update that is complete at `now`.
  std::optional<OdometryUpdate> next(const ros::Time& now);

  /// When next() must be called again even if no message comes.
  std::optional<ros::Time> deadline() const;

  /// Puts the car at the pose of a message.
  /// @return why it was refused, empty when it was not
  std::string setPose(const geometry_msgs::PoseWithCovarianceStamped& message);

  /// Takes what a calibration has found so far; the pose stays.
  /// @return why it was refused, empty when it was not
  std::string add(const CalibrationState& message);

  void reset() { pipeline_.reset(); }
  /// The clock went back: with simulated time a new run begins, otherwise only the time does.
  void clockWentBack(bool simulated_time);

  const OdometryPipeline& pipeline() const { return pipeline_; }
  const OutputFrames& frames() const { return frames_; }
  const CalibrationAcceptance& acceptance() const { return acceptance_; }

 private:
  std::optional<Time> stampOf(const ros::Time& stamp, const ros::Time& receipt) const;
  Verdict addWheels(const WheelCounts& counts, const Sender& sender);
  Verdict addSteering(Axle axle, Time stamp, Time receipt, double reading, const Sender& sender);
  Verdict addSteeringJoints(const JointPositions& joints, Time stamp, Time receipt, const Sender& sender);
  std::optional<Verdict> addWheelJoints(const JointPositions& joints, Time stamp, Time receipt,
                                        const Sender& sender);

  Parameters parameters_;
  OutputFrames frames_;
  OdometryPipeline pipeline_;
  CalibrationAcceptance acceptance_;
  PublisherWatch wheel_publishers_;
  PerAxle<PublisherWatch> steering_publishers_;
};

}  // namespace bs_car_odometry
