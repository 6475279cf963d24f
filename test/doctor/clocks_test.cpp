// Rates, gaps, stamps and clocks.

#include "damaged_drive.hpp"

#include <gmock/gmock.h>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const ros::Time kStart(1600000000, 0);

/// Seconds since the start.
double secondsOf(const std_msgs::Header& header) { return (header.stamp - kStart).toSec(); }

TEST(DoctorOfClocks, tellsRatesAndTheLongestInterval) {
  EXPECT_THAT(report(Patient(cycab()).examine()),
              AllOf(HasSubstr("ok     wheel_ticks: 3001 messages, 50.0 Hz, longest interval 0.020 s"),
                    HasSubstr("ok     laser_pose: 601 messages, 10.0 Hz")));
}

TEST(DoctorOfClocks, findsGaps) {
  const Damage damage = onWheels([](WheelTicks& wheels) {
    const double t = secondsOf(wheels.header);
    return !(t > 10.0 && t < 11.5) && !(t > 30.0 && t < 30.7);
  });
  // 10.00 to 11.50: the messages at both ends are there. The first message, an angle, is recorded 1 ms late.
  EXPECT_THAT(troubles(Patient(cycab()).examine(damage)),
              HasSubstr("WARN   wheel_ticks: 2 gaps beyond max_gap, the longest 1.50 s at 10.0 s"));
}

TEST(DoctorOfClocks, findsIrregularMessages) {
  int message = 0;
  // Five messages in sixteen are lost in a row: one interval in ten is six times as long as the others.
  EXPECT_THAT(troubles(Patient(cycab()).examine(onSteering([&](SteeringAngle&) {
                const int i = message++ % 16;
                return i < 9 || i == 15;
              }))),
              HasSubstr("WARN   front_steering: irregular"));
}

TEST(DoctorOfClocks, findsSlowTopics) {
  Patient patient(cycab());
  patient.settings().laser_rate = 0.5;
  EXPECT_THAT(troubles(patient.examine()), HasSubstr("WARN   laser_pose: 0.5 Hz, less than 1 Hz"));
}

TEST(DoctorOfClocks, findsStampZero) {
  EXPECT_THAT(
      errors(Patient(cycab()).examine(onSteering([](SteeringAngle& steering) {
        steering.header.stamp = ros::Time();
        return true;
      }))),
      HasSubstr("ERROR  front_steering: 3001 of 3001 messages have stamp zero or none: stamp the messages at "
                "the source, or set stamp_source: receipt"));
}

TEST(DoctorOfClocks, asksForNoStampsThatAreNotRead) {
  Parameters configured = cycab();
  configured.stamp_source = StampSource::kReceipt;
  EXPECT_EQ(errors(Patient(cycab()).examine(configured, onSteering([](SteeringAngle& steering) {
                                              steering.header.stamp = ros::Time();
                                              return true;
                                            }))),
            "");
}

TEST(DoctorOfClocks, findsStampsFromTheFuture) {
  EXPECT_THAT(errors(Patient(cycab()).examine(onWheels([](WheelTicks& wheels) {
                wheels.header.stamp += ros::Duration(3600.0);
                return true;
              }))),
              HasSubstr("wheel_ticks: 3001 of 3001 stamps are later than their record, by 3599.999 s"));
}

TEST(DoctorOfClocks, findsJumpsBack) {
  EXPECT_THAT(troubles(Patient(cycab()).examine(onWheels([](WheelTicks& wheels) {
                if (secondsOf(wheels.header) > 20.0 && secondsOf(wheels.header) < 20.15)
                  wheels.header.stamp -= ros::Duration(2.0);
                return true;
              }))),
              HasSubstr("WARN   wheel_ticks: 7 of 3001 stamps jump back, by up to 1.980 s"));
}

TEST(DoctorOfClocks, findsRepeatedStamps) {
  int message = 0;
  ros::Time before;
  // Every tenth message carries the stamp of the one before.
  EXPECT_THAT(troubles(Patient(cycab()).examine(onSteering([&](SteeringAngle& steering) {
                if (++message % 10 == 0) steering.header.stamp = before;
                before = steering.header.stamp;
                return true;
              }))),
              HasSubstr("WARN   front_steering: 300 of 3001 stamps repeat the one before"));
}

TEST(DoctorOfClocks, findsClocksOfTwoMachines) {
  EXPECT_THAT(troubles(Patient(cycab()).examine(onLaser([](auto& pose) {
                pose.header.stamp -= ros::Duration(0.4);
                return true;
              }))),
              HasSubstr("WARN   laser_pose is recorded 0.40 s later after its stamp than the wheels"));
}

TEST(DoctorOfClocks, findsRecordsLongAfterTheStamps) {
  EXPECT_THAT(troubles(Patient(cycab()).examine([](SimulatedMessage& message) {
                message.receipt += std::chrono::seconds(1);
                return true;
              })),
              HasSubstr("WARN   wheel_ticks: recorded 1.00 s after the stamps"));
}

TEST(DoctorOfClocks, findsALaserThatWasNotRunning) {
  EXPECT_THAT(
      troubles(Patient(cycab()).examine(onLaser([](auto& pose) { return secondsOf(pose.header) >= 40.0; }))),
      HasSubstr("WARN   laser_pose covers 20.0 s of the 60.0 s"));
  EXPECT_THAT(errors(Patient(cycab()).examine(onLaser([](auto& pose) {
                pose.header.stamp -= ros::Duration(1000.0);
                return true;
              }))),
              HasSubstr("ERROR  laser_pose and the wheels have no stamps in common"));
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
