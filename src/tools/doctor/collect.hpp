#pragma once

#include "drive_record.hpp"

#include "bs_car_odometry/SteeringAngle.h"
#include "bs_car_odometry/WheelTicks.h"
#include "bs_car_odometry/ros/joint_state_reader.hpp"

#include <geometry_msgs/PoseWithCovarianceStamped.h>

namespace bs_car_odometry::tools::doctor {

/// Fills a record, message by message in the order of a bag.
class Collector {
 public:
  explicit Collector(const Parameters& parameters) : record_(parameters) {}

  void add(const WheelTicks& message, const ros::Time& record_time);
  void add(Axle axle, const SteeringAngle& message, const ros::Time& record_time);
  void add(const RawJointState& message, const ros::Time& record_time);
  void add(const geometry_msgs::PoseWithCovarianceStamped& message, const ros::Time& record_time);

  /// At the end of the bag: where the laser sits, by the configuration or by tf.
  void setMount(const LaserMount& mount);

  const DriveRecord& record() const { return record_; }

 private:
  struct Stamps {
    std::optional<Time> stamp;  ///< of the message, or of its record with `stamp_source: receipt`
    Time record;
  };
  Stamps stampsOf(const ros::Time& stamp, const ros::Time& record_time);
  void addWheels(const Stamps& stamps, const PerWheel<std::int64_t>& ticks);
  void addSteering(Axle axle, const Stamps& stamps, double reading);
  bool wheelTicksOf(const JointPositions& joints, PerWheel<std::int64_t>& ticks) const;

  DriveRecord record_;
  PerWheel<double> travel_;
};

}  // namespace bs_car_odometry::tools::doctor
