// Whether the drive shows every gain.

#include "damaged_drive.hpp"

#include "../../src/tools/calibrate.hpp"

#include <gmock/gmock.h>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(DoctorOfExcitation, aStraightDriveLeavesTheTracksOpen) {
  const doctor::Examination examination = Patient(frontSteered(), "straight").examine();
  EXPECT_THAT(
      troubles(examination),
      AllOf(
          HasSubstr("WARN   rear/k_b: standard deviation 0.05 before, 0.05 after this drive, not observed\n"),
          HasSubstr("WARN   front/k_b"),
          HasSubstr("WARN   the drive does not show every parameter: front/k_b, rear/k_b: turn "),
          Not(HasSubstr("WARN   rear/k_r")), Not(HasSubstr("ERROR"))));
  EXPECT_THAT(report(examination), HasSubstr("ok     rear/k_r"));
  EXPECT_EQ(examination.exitStatus(), kNotObservedStatus);
}

TEST(DoctorOfExcitation, eightsShowEverything) {
  const doctor::Examination examination = Patient(cycab()).examine();
  EXPECT_THAT(report(examination), AllOf(HasSubstr("ok     drive: "), HasSubstr("ok     rear/k_b: ")));
  EXPECT_EQ(examination.exitStatus(), 0);
}

/// The names and standard deviations are those of the calibration with the same configuration.
TEST(DoctorOfExcitation, asksForWhatIsEstimated) {
  Parameters car = cycab();
  car.odometry.axles = AxleSelection::kRear;
  car.calibration.estimate = {"gains", "steering_offset", "laser_mount", "time_offset"};
  const std::string text = report(Patient(car).examine());
  EXPECT_THAT(text, AllOf(HasSubstr("rear/k_b: "), HasSubstr("front/steering_offset: "),
                          HasSubstr("laser/x: "), HasSubstr("laser/time_offset: ")));
  EXPECT_THAT(text, Not(HasSubstr("front/k_b")));
}

TEST(DoctorOfExcitation, anErrorCountsMore) {
  const doctor::Examination examination =
      Patient(frontSteered(), "straight").examine(onSteering([](SteeringAngle& steering) {
        steering.header.stamp = ros::Time();
        return true;
      }));
  EXPECT_EQ(examination.exitStatus(), 3);
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
