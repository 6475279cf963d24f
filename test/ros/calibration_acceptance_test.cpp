// What the odometry takes of the messages on `calibration`, without a master.

#include "bs_car_odometry/ros/odometry_adapter.hpp"

#include "bs_car_odometry/calibration/result_file.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>

namespace bs_car_odometry {
namespace {

using calibration::kCount;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Parameters cycab() {
  Parameters parameters;
  parameters.vehicle.name = "cycab";
  parameters.vehicle.wheelbase = 1.2;
  parameters.vehicle.track = {1.2, 1.2};
  parameters.vehicle.metres_per_tick = {{1e-4, 1e-4, 1e-4, 1e-4}};
  parameters.accept_calibration = true;
  // Counters and angles of these tests are made up, and contradict each other.
  parameters.odometry.fault_detection = false;
  return parameters;
}

/// Gains of the rear axle and the front steering are observed; the laser's mount is too, but moves no car.
CalibrationState state() {
  CalibrationState message;
  message.vehicle = "cycab";
  message.vehicle_checksum = calibration::vehicleChecksum(cycab());
  message.state = CalibrationState::RUNNING;
  const calibration::ParameterVector values = calibration::valuesOf(cycab());
  std::copy(values.data(), values.data() + kCount, message.value.begin());
  for (const std::size_t i : {std::size_t{systematic::kRearRight}, std::size_t{systematic::kRearLeft},
                              std::size_t{systematic::kFrontOffset}, std::size_t{calibration::kFrontScale},
                              std::size_t{calibration::kLaserX}}) {
    message.estimated[i] = message.observed[i] = 1;
    message.value[i] += 0.01;
    message.deviation[i] = 0.001;
    message.covariance[i * kCount + i] = 1e-6;
  }
  message.covariance[systematic::kRearRight * kCount + systematic::kRearLeft] = 5e-7;
  message.covariance[systematic::kRearLeft * kCount + systematic::kRearRight] = 5e-7;
  return message;
}

OdometryCalibration inUse(const OdometryAdapter& adapter) { return adapter.pipeline().calibration(); }

bool isNominal(const OdometryAdapter& adapter) {
  const OdometryCalibration nominal = OdometryPipeline(toConfiguration(cycab())).calibration();
  const OdometryCalibration used = inUse(adapter);
  return used.gains.rear.k_r == nominal.gains.rear.k_r && used.gains.rear.k_l == nominal.gains.rear.k_l &&
         used.steering.front.offset == nominal.steering.front.offset && used.covariance == nominal.covariance;
}

TEST(CalibrationAcceptance, takesWhatIsObserved) {
  OdometryAdapter adapter(cycab());
  CalibrationState message = state();
  message.value[systematic::kRearTrack] = 1.3;  // not observed
  message.covariance[systematic::kRearTrack * kCount + systematic::kRearTrack] = 0.04;
  EXPECT_THAT(adapter.add(message), IsEmpty());
  const OdometryCalibration used = inUse(adapter);
  EXPECT_EQ(used.gains.rear.k_r, 1.01);
  EXPECT_EQ(used.gains.rear.k_l, 1.01);
  EXPECT_EQ(used.gains.rear.k_b, 1.0);
  EXPECT_EQ(used.gains.front.k_r, 1.0);
  EXPECT_EQ(used.steering.front.offset, 0.01);
  EXPECT_EQ(used.steering.front.scale, 1.01);
  EXPECT_EQ(used.covariance(systematic::kRearRight, systematic::kRearRight), 1e-6);
  EXPECT_EQ(used.covariance(systematic::kRearRight, systematic::kRearLeft), 5e-7);
  EXPECT_DOUBLE_EQ(used.covariance(systematic::kRearTrack, systematic::kRearTrack),
                   4e-4);  // noise/systematic
  EXPECT_EQ(adapter.acceptance().taken(), 1u);
}

TEST(CalibrationAcceptance, takesNothingWhereNothingIsObserved) {
  OdometryAdapter adapter(cycab());
  CalibrationState message = state();
  message.observed.assign(0);
  EXPECT_THAT(adapter.add(message), IsEmpty());
  EXPECT_TRUE(isNominal(adapter));
  EXPECT_EQ(adapter.acceptance().taken(), 0u);
}

/// What was found stays when the calibration begins anew.
TEST(CalibrationAcceptance, keepsWhatItHas) {
  OdometryAdapter adapter(cycab());
  adapter.add(state());
  CalibrationState message = state();
  message.observed.assign(0);
  message.observed[systematic::kRearLeft] = 1;
  message.value[systematic::kRearLeft] = 1.02;
  EXPECT_THAT(adapter.add(message), IsEmpty());
  EXPECT_EQ(inUse(adapter).gains.rear.k_l, 1.02);
  EXPECT_EQ(inUse(adapter).gains.rear.k_r, 1.01);
  EXPECT_EQ(inUse(adapter).covariance(systematic::kRearRight, systematic::kRearLeft), 0.0);
}

TEST(CalibrationAcceptance, takesOnlyNews) {
  OdometryAdapter adapter(cycab());
  adapter.add(state());
  const auto taken = [&](std::size_t parameter, double change, double variance) {
    CalibrationState message = state();
    message.value[parameter] += change;
    message.covariance[parameter * kCount + parameter] = variance;
    const std::uint64_t before = adapter.acceptance().taken();
    EXPECT_THAT(adapter.add(message), IsEmpty());
    return adapter.acceptance().taken() > before;
  };
  EXPECT_FALSE(taken(systematic::kRearRight, 0.0, 1e-6)) << "the same again";
  EXPECT_FALSE(taken(systematic::kRearRight, 0.00009, 1e-6)) << "a tenth of the deviation is 0.0001";
  EXPECT_FALSE(taken(systematic::kRearRight, 0.0, 0.83e-6)) << "a deviation of 0.91";
  EXPECT_FALSE(taken(calibration::kLaserX, 0.1, 1e-2)) << "moves no car";
  EXPECT_TRUE(taken(systematic::kRearRight, 0.00011, 1e-6));
  EXPECT_TRUE(taken(systematic::kFrontOffset, 0.0, 0.79e-6)) << "a deviation of 0.89";
  EXPECT_TRUE(taken(systematic::kFrontOffset, 0.0, 1.3e-6)) << "a deviation that grew";
}

TEST(CalibrationAcceptance, refusesAnotherCar) {
  OdometryAdapter adapter(cycab());
  CalibrationState message = state();
  message.vehicle = "cycab2";
  EXPECT_THAT(adapter.add(message), HasSubstr("another car's"));
  message = state();
  message.vehicle_checksum ^= 1u;
  EXPECT_THAT(adapter.add(message), HasSubstr("another car's"));
  EXPECT_TRUE(isNominal(adapter));
}

TEST(CalibrationAcceptance, refusesGarbage) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr std::size_t kR = systematic::kRearRight;
  constexpr std::size_t kL = systematic::kRearLeft;
  const std::vector<std::pair<const char*, std::function<void(CalibrationState&)>>> garbage{
      {"finite", [](auto& m) { m.value[kR] = kNan; }},
      {"finite", [](auto& m) { m.value[systematic::kFrontOffset] = kInfinity; }},
      {"rear/k_r is not within", [](auto& m) { m.value[kR] = 2.1; }},
      {"rear/k_l is not within", [](auto& m) { m.value[kL] = -1.0; }},
      {"steering_scale is not within", [](auto& m) { m.value[calibration::kFrontScale] = 0.0; }},
      {"steering_offset is not within", [](auto& m) { m.value[systematic::kFrontOffset] = 4.0; }},
      {"covariance", [](auto& m) { m.covariance[kR * kCount + kR] = kNan; }},
      {"covariance", [](auto& m) { m.covariance[kR * kCount + kR] = kInfinity; }},
      {"covariance", [](auto& m) { m.covariance[kR * kCount + kR] = -1e-6; }},
      {"covariance", [](auto& m) { m.covariance[kR * kCount + kL] = 4e-7; }},
      {"covariance",
       [](auto& m) { m.covariance[kR * kCount + kL] = m.covariance[kL * kCount + kR] = 1.1e-6; }},
      {"covariance", [](auto& m) { m.covariance.assign(1e308); }},
  };
  for (const auto& [says, change] : garbage) {
    OdometryAdapter adapter(cycab());
    CalibrationState message = state();
    change(message);
    EXPECT_THAT(adapter.add(message), HasSubstr(says));
    EXPECT_TRUE(isNominal(adapter)) << says;
  }
}

/// 2 m with a calibration that gets better and better: no step is longer than the counters say.
TEST(CalibrationAcceptance, thePoseDoesNotJump) {
  OdometryAdapter adapter(cycab());
  std::optional<OdometryUpdate> before;
  for (int i = 0; i <= 200; ++i) {
    const ros::Time stamp(1000.0 + 0.02 * i);
    SteeringAngle steering;
    steering.header.stamp = stamp;
    steering.angle = 0.1;
    adapter.add(Axle::kFront, steering, stamp);
    CalibrationState message = state();
    const double rest = 0.05 / (1.0 + i);
    message.value[systematic::kRearRight] = 1.02 + rest;
    message.value[systematic::kRearLeft] = 0.98 - rest;
    message.covariance[systematic::kRearRight * kCount + systematic::kRearRight] = rest * rest;
    message.covariance[systematic::kRearLeft * kCount + systematic::kRearLeft] = rest * rest;
    message.covariance[systematic::kRearRight * kCount + systematic::kRearLeft] = 0.0;
    message.covariance[systematic::kRearLeft * kCount + systematic::kRearRight] = 0.0;
    EXPECT_THAT(adapter.add(message), IsEmpty());
    WheelTicks wheels;
    wheels.header.stamp = stamp;
    wheels.front_left = wheels.front_right = wheels.rear_left = wheels.rear_right = 100 * i;
    adapter.add(wheels, stamp);
    const auto update = adapter.next(stamp);
    ASSERT_TRUE(update) << i;
    if (before) {
      const Pose2& from = before->estimate.pose;
      const Pose2& to = update->estimate.pose;
      // 10 mm times gains of at most 1.07, and a difference of the rear wheels of 1.4 mm over the track.
      EXPECT_LT(std::hypot(to.x - from.x, to.y - from.y), 0.0108) << i;
      EXPECT_LT(std::abs(to.yaw - from.yaw), 0.005) << i;
      const double grown = (update->estimate.pose_covariance - before->estimate.pose_covariance).norm();
      EXPECT_LT(grown, 0.1 * update->estimate.pose_covariance.norm() + 1e-5) << i;
      // The determinant would show a covariance that forgets.
      EXPECT_GE(update->estimate.pose_covariance(0, 0), before->estimate.pose_covariance(0, 0)) << i;
    }
    before = update;
  }
  EXPECT_GT(adapter.acceptance().taken(), 10u);
}

}  // namespace
}  // namespace bs_car_odometry
