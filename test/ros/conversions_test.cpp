// Where messages become readings and back: every value of a field, and no exception (docs/reliability.md, T9,
// C1).

#include "bs_car_odometry/ros/conversions.hpp"

#include "bs_car_odometry/parameters/load.hpp"
#include "bs_car_odometry/ros/odometry_adapter.hpp"
#include "parameters/vehicle_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace bs_car_odometry {
namespace {

std::vector<std::uint32_t> powersOfTwo() {
  std::vector<std::uint32_t> values{0, std::numeric_limits<std::uint32_t>::max(), 999999999, 1000000000};
  for (int bit = 0; bit < 32; ++bit) {
    values.push_back(1u << bit);
    values.push_back((1u << bit) - 1);
  }
  return values;
}

ros::Time raw(std::uint32_t sec, std::uint32_t nsec) {
  ros::Time stamp;
  stamp.sec = sec;
  stamp.nsec = nsec;
  return stamp;
}

TEST(Stamps, T9_every_power_of_two) {
  for (const std::uint32_t sec : powersOfTwo())
    for (const std::uint32_t nsec : powersOfTwo()) {
      std::optional<Time> time;
      ASSERT_NO_THROW(time = toTime(raw(sec, nsec)));
      ASSERT_EQ(time.has_value(), nsec < 1000000000u) << sec << " " << nsec;
      if (time) {
        ASSERT_EQ(toRos(*time), raw(sec, nsec));
      }
    }
}

TEST(Stamps, T9_every_time_of_the_core_can_be_published) {
  for (int bit = 0; bit < 64; ++bit) {
    const auto nanoseconds = static_cast<std::int64_t>(std::uint64_t{1} << bit);
    for (const std::int64_t value : {nanoseconds, nanoseconds - 1, -(nanoseconds - 1)})
      ASSERT_NO_THROW(toRos(timeFromNanoseconds(value))) << value;
  }
}

TEST(Stamps, T9_adapter_takes_every_stamp_and_every_clock) {
  for (const std::uint32_t clock : {0u, 1600000000u, std::numeric_limits<std::uint32_t>::max()}) {
    OdometryAdapter adapter(testing::load(testing::kMinimalVehicle).parameters);
    for (const std::uint32_t sec : powersOfTwo())
      for (const std::uint32_t nsec : powersOfTwo()) {
        const ros::Time receipt = raw(clock, nsec);
        WheelTicks wheels;
        wheels.header.stamp = raw(sec, nsec);
        SteeringAngle angle;
        angle.header.stamp = raw(sec, nsec);
        ASSERT_NO_THROW(adapter.add(Axle::kFront, angle, receipt));
        ASSERT_NO_THROW(adapter.add(wheels, receipt));
        ASSERT_NO_THROW(adapter.next(receipt));
        ASSERT_NO_THROW(adapter.deadline());
      }
  }
}

TEST(Quaternions, C1_norm_outside_0_9_to_1_1_is_none) {
  geometry_msgs::Quaternion q;
  for (const double norm : {0.0, 0.89, 1.11, 1e200, std::nan(""), std::numeric_limits<double>::infinity()}) {
    q.w = norm;
    EXPECT_FALSE(toYaw(q)) << norm;
  }
  for (const double norm : {0.91, 1.0, 1.09}) {
    q.w = norm * std::cos(0.5);
    q.z = norm * std::sin(0.5);
    ASSERT_TRUE(toYaw(q));
    EXPECT_NEAR(*toYaw(q), 1.0, 1e-15);
  }
}

TEST(Quaternions, O6_yaw_is_there_and_back) {
  for (double yaw = -3.14; yaw < 3.14; yaw += 0.01) {
    EXPECT_NEAR(*toYaw(toQuaternion(yaw)), yaw, 1e-15);
    EXPECT_NEAR(*toYaw(toQuaternion(yaw + 2000.0 * M_PI)), yaw, 1e-11);
  }
}

TEST(Covariances, O5_planarOnesAreThereAndBack) {
  Eigen::Matrix3d covariance;
  covariance << 1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 3.0;
  const boost::array<double, 36> message = toCovariance(covariance, 7.0);
  EXPECT_EQ(toPlanarCovariance(message), covariance);
  for (const std::size_t unmeasured : {14, 21, 28}) EXPECT_EQ(message[unmeasured], 7.0);
  EXPECT_EQ(message[5], 0.2);
  EXPECT_EQ(message[30], 0.2);
}

TEST(Covariances, negativeOnesAreNone) {
  EXPECT_TRUE(isCovariance(Eigen::Matrix3d::Zero()));
  EXPECT_TRUE(isCovariance(Eigen::Matrix3d::Identity() * 1e300));
  EXPECT_FALSE(isCovariance(-Eigen::Matrix3d::Identity()));
  EXPECT_FALSE(isCovariance(Eigen::Vector3d(1.0, 1.0, -1e-8).asDiagonal()));
  EXPECT_FALSE(isCovariance(Eigen::Matrix3d::Constant(std::nan(""))));
}

TEST(Particles, areSpreadOverAllOfThem) {
  OdometryConfiguration configuration;
  configuration.vehicle.wheelbase = 1.2;
  configuration.vehicle.track = {1.2, 1.2};
  configuration.vehicle.metres_per_tick.values.fill(1e-4);
  configuration.options.uncertainty = Uncertainty::kMonteCarlo;
  configuration.options.particles.count = 1000;
  configuration.initial_pose.covariance.setIdentity();
  const OdometryEstimator estimator(configuration);
  geometry_msgs::PoseArray message;
  fillParticles({}, estimator.uncertainty(), {"odom", "base_link", 0.0}, 10, message);
  ASSERT_EQ(message.poses.size(), 10u);
  EXPECT_EQ(message.header.frame_id, "odom");
  const Pose2 last = estimator.uncertainty().particle(900);
  EXPECT_EQ(message.poses[9].position.x, last.x);
  EXPECT_EQ(message.poses[9].position.y, last.y);
  EXPECT_NEAR(*toYaw(message.poses[9].orientation), wrapAngle(last.yaw), 1e-12);
  fillParticles({}, estimator.uncertainty(), {"odom", "base_link", 0.0}, 5000, message);
  EXPECT_EQ(message.poses.size(), 1000u);
}

}  // namespace
}  // namespace bs_car_odometry
