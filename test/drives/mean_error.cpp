#include "mean_error.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <functional>

namespace bs_car_odometry::drives {

namespace {

/// Motion of one step and its mean over the noise of the readings.
class StepMean {
 public:
  explicit StepMean(const OdometryConfiguration& configuration)
      : configuration_(configuration), estimator_(configuration) {}

  /// Mean motion less the motion without noise.
  BodyMotion excess(const StepReadings& readings) {
    const NoiseModel& noise = configuration_.noise;
    BodyMotion excess = BodyMotion::Zero();
    double travel = 0.0;  // of the wheels, on average
    for (const Wheel wheel : kAllWheels) {
      const double length = std::abs(readings.travel[wheel]);
      travel += 0.25 * length;
      excess += curvature(readings, [&](StepReadings& r, double sign) {
        r.travel[wheel] += sign * noise.wheel.std() * std::sqrt(length);
      });
    }
    if (travel <= 0.0) return excess;
    const double std = noise.steering.angle.std() * std::sqrt(noise.steering.correlation_length / travel);
    return excess + curvature(readings, [&](StepReadings& r, double sign) {
             r.begin = steering(r.begin.front + sign * std);
             r.end = steering(r.end.front + sign * std);
           });
  }

  SteeringAngles steering(double front) const {
    return {front, configuration_.vehicle.rear_steering.angle(front)};
  }

 private:
  using Shift = std::function<void(StepReadings&, double sign)>;

  BodyMotion curvature(const StepReadings& readings, const Shift& shift) {
    StepReadings above = readings;
    StepReadings below = readings;
    shift(above, 1.0);
    shift(below, -1.0);
    return 0.5 * (motion(above) + motion(below)) - motion(readings);
  }

  BodyMotion motion(const StepReadings& readings) {
    estimator_.step(readings, std::nullopt);
    return estimator_.lastIncrement().motion;
  }

  OdometryConfiguration configuration_;
  OdometryEstimator estimator_;
};

StepReadings readingsBetween(const Vehicle& vehicle, const StepMean& mean, const Sample& from,
                             const Sample& to) {
  StepReadings readings;
  for (const Wheel wheel : kAllWheels)
    readings.travel[wheel] =
        vehicle.calibratedMetresPerTick(wheel) * static_cast<double>(to.ticks[wheel] - from.ticks[wheel]);
  readings.begin = mean.steering(from.steering.front);
  readings.end = mean.steering(to.steering.front);
  return readings;
}

}  // namespace

Eigen::Vector3d meanError(const OdometryConfiguration& configuration, const std::vector<Sample>& drive) {
  StepMean step_mean(configuration);
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  const Sample* from = nullptr;
  OdometryEstimate before;
  replay(configuration, drive, [&](const Sample& to, const OdometryUpdate& update) {
    const OdometryEstimate& estimate = update.estimate;
    if (from != nullptr) {
      const BodyMotion excess =
          step_mean.excess(readingsBetween(configuration.vehicle, step_mean, *from, to));
      const Eigen::Vector2d d = estimate.pose.position() - before.pose.position();
      const Eigen::Rotation2Dd R_odom_base(0.5 * (before.pose.yaw + estimate.pose.yaw));
      error.head<2>() += R_odom_base * excess.head<2>() + error.z() * Eigen::Vector2d(-d.y(), d.x()) -
                         0.5 * before.pose_covariance(2, 2) * d;
      error.z() += excess.z();
    }
    from = &to;
    before = estimate;
  });
  return error;
}

}  // namespace bs_car_odometry::drives
