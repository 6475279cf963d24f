// Frames, covariances, jumps and lag of the laser.

#include "damaged_drive.hpp"

#include "../../src/tools/doctor/collect.hpp"
#include "../../src/tools/doctor/laser_lag.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <iostream>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

using LaserMessage = geometry_msgs::PoseWithCovarianceStamped;

double secondsOf(const LaserMessage& pose) { return (pose.header.stamp - ros::Time(1600000000, 0)).toSec(); }

/// The lag that the doctor finds in a drive whose laser is late by `offset`.
std::optional<doctor::LaserLag> lagOf(const Parameters& car, SimulatedDriveSettings settings, double offset) {
  Parameters late = car;
  late.laser.time_offset = offset;
  SimulatedDrive drive(late, settings, Time(durationFromSeconds(1.6e9)));
  doctor::Collector collector(car);
  while (const std::optional<SimulatedMessage> message = drive.next()) {
    const ros::Time receipt = toRos(message->receipt);
    if (const auto* wheels = std::get_if<WheelTicks>(&message->content)) collector.add(*wheels, receipt);
    if (const auto* pose = std::get_if<LaserMessage>(&message->content)) collector.add(*pose, receipt);
  }
  return doctor::estimateLaserLag(collector.record());
}

/// The lag is found, and its standard deviation is one: 40 drives give a mean square of lag error over sigma
/// whose 99.9 % interval is 0.41 to 1.96 (chi-square, 40 degrees of freedom). Neighbouring stretches share
/// their poses, and the doctor allows for that by the full overlap, which is more than it must: the lower
/// end is lowered to 0.1.
TEST(DoctorOfLaser, findsTheLagWithItsUncertainty) {
  for (const double offset : {0.0, 0.1, -0.05}) {
    double sum = 0.0;
    constexpr int kDrives = 40;
    for (int seed = 1; seed <= kDrives; ++seed) {
      SimulatedDriveSettings settings;
      settings.scenario = seed % 2 == 0 ? "fig4" : "slalom_eight";
      settings.seed = static_cast<std::uint64_t>(seed);
      const std::optional<doctor::LaserLag> lag = lagOf(cycab(), settings, offset);
      ASSERT_TRUE(lag) << seed;
      const double ratio = (lag->lag - offset) / lag->sigma;
      EXPECT_LT(std::abs(ratio), 4.0) << offset << " s, seed " << seed;
      EXPECT_LT(lag->sigma, 0.03);
      sum += ratio * ratio / kDrives;
    }
    std::cout << "offset " << offset << " s: mean square of error over sigma " << sum << std::endl;
    EXPECT_GT(sum, 0.1);
    EXPECT_LT(sum, 1.96);
  }
}

TEST(DoctorOfLaser, saysWhenADriveDoesNotShowTheLag) {
  SimulatedDriveSettings settings;
  settings.scenario = "circle";
  EXPECT_FALSE(lagOf(cycab(), settings, 0.1));
}

TEST(DoctorOfLaser, warnsOfALagAndTellsTheParameter) {
  Patient patient(cycab(), "fig4");
  patient.recordedWith().laser.time_offset = 0.1;
  EXPECT_THAT(troubles(patient.examine(cycab())),
              AllOf(HasSubstr("WARN   laser_pose is "), HasSubstr(" ms late, where laser/time_offset is 0 s"),
                    HasSubstr("calibration/estimate=[gains, time_offset]")));
  Parameters configured = cycab();
  configured.laser.time_offset = 0.1;
  EXPECT_EQ(troubles(patient.examine(configured)), "");
  configured = cycab();
  configured.calibration.estimate = {"gains", "time_offset"};
  EXPECT_EQ(troubles(patient.examine(configured)), "");
}

TEST(DoctorOfLaser, missesTheFrameInTf) {
  Parameters car = cycab();
  car.laser.frame = "laser";
  const Damage without_tf = [](SimulatedMessage& message) { return message.topic != "tf_static"; };
  EXPECT_THAT(errors(Patient(car).examine(without_tf)),
              HasSubstr("ERROR  laser/frame is 'laser', and no tf in the bag connects it with 'base_link'"));
}

TEST(DoctorOfLaser, looksAtTheFrameOfThePoses) {
  const auto framed = [](const std::string& frame, double from) {
    return onLaser([=](LaserMessage& pose) {
      if (secondsOf(pose) >= from) pose.header.frame_id = frame;
      return true;
    });
  };
  EXPECT_THAT(troubles(Patient(cycab()).examine(framed("", 0.0))),
              HasSubstr("WARN   laser_pose has an empty frame_id"));
  EXPECT_THAT(errors(Patient(cycab()).examine(framed("other", 30.0))),
              HasSubstr("ERROR  laser_pose comes in several frames: 'map', 'other'"));
  EXPECT_THAT(errors(Patient(cycab()).examine(framed("/base_link", 0.0))),
              HasSubstr("ERROR  laser_pose is given in"));
}

TEST(DoctorOfLaser, looksAtCovariances) {
  const auto with = [](double x, double xy) {
    return onLaser([=](LaserMessage& pose) {
      pose.pose.covariance.assign(0.0);
      pose.pose.covariance[0] = pose.pose.covariance[7] = pose.pose.covariance[35] = x;
      pose.pose.covariance[1] = pose.pose.covariance[6] = xy;
      return true;
    });
  };
  EXPECT_THAT(troubles(Patient(cycab()).examine(with(0.0, 0.0))),
              HasSubstr("WARN   laser_pose: 601 of 601 poses have no covariance: laser_sigma holds"));
  EXPECT_THAT(errors(Patient(cycab()).examine(with(1e-4, 2e-4))),
              HasSubstr("ERROR  laser_pose: 601 of 601 covariances are not finite or not positive definite"));
}

TEST(DoctorOfLaser, looksAtPosesThatAreNone) {
  EXPECT_THAT(errors(Patient(cycab()).examine(onLaser([](LaserMessage& pose) {
                if (secondsOf(pose) > 50.0) pose.pose.pose.orientation = geometry_msgs::Quaternion();
                return true;
              }))),
              HasSubstr("ERROR  laser_pose: 100 of 601 poses are not finite or have no quaternion"));
}

TEST(DoctorOfLaser, findsJumps) {
  EXPECT_THAT(troubles(Patient(cycab()).examine(onLaser([](LaserMessage& pose) {
                if (secondsOf(pose) >= 30.0) pose.pose.pose.position.x += 1.0;
                return true;
              }))),
              HasSubstr("WARN   laser_pose jumps 1 times"));
  EXPECT_THAT(troubles(Patient(cycab()).examine(onLaser([](LaserMessage& pose) {
                const int tenth = static_cast<int>(std::lround(10.0 * secondsOf(pose)));
                if (tenth % 100 == 50) pose.pose.pose.position.y += 3.0;
                return true;
              }))),
              HasSubstr("WARN   laser_pose jumps 6 times"));
}

TEST(DoctorOfLaser, findsALocaliserThatIsLost) {
  EXPECT_THAT(errors(Patient(cycab()).examine(onLaser([](LaserMessage& pose) {
                pose.pose.pose = geometry_msgs::Pose();
                pose.pose.pose.orientation.w = 1.0;
                return true;
              }))),
              HasSubstr("ERROR  laser_pose stays where it is"));
}

TEST(DoctorOfLaser, findsALaserThatLooksElsewhere) {
  Patient patient(frontSteered(), "square_loop");
  patient.recordedWith().laser.yaw = 0.5 * M_PI;
  EXPECT_THAT(
      errors(patient.examine(frontSteered())),
      AllOf(HasSubstr("turned by 90."), HasSubstr("--set laser/yaw=1.5"), Not(HasSubstr("exchanged"))));
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
