// Steering in degrees, with the wrong sign, dead.

#include "damaged_drive.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

Damage multiplied(double factor) {
  return onSteering([=](SteeringAngle& steering) {
    steering.angle *= factor;
    return true;
  });
}

TEST(DoctorOfSteering, noticesDegreesBeyondTheLimit) {
  EXPECT_THAT(errors(Patient(cycab()).examine(multiplied(180.0 / M_PI))),
              AllOf(HasSubstr("beyond steering_limit"), HasSubstr("--set steering/front/scale=0.0174533")));
}

/// Degrees that pass the limit show against the laser: it is raised above the drive's 15 degrees.
TEST(DoctorOfSteering, noticesDegreesBelowTheLimit) {
  Patient patient(cycab(), "fig4");
  Parameters configured = cycab();
  configured.limits.steering_limit = 16.0;
  EXPECT_THAT(
      errors(patient.examine(configured, multiplied(180.0 / M_PI))),
      AllOf(HasSubstr("front_steering is in degrees"), HasSubstr("--set steering/front/scale=0.017")));
}

TEST(DoctorOfSteering, noticesAnglesThatWereConvertedTwice) {
  EXPECT_THAT(errors(Patient(cycab()).examine(multiplied(M_PI / 180.0))),
              AllOf(HasSubstr("turned from degrees to radians twice"),
                    HasSubstr("--set steering/front/scale=57.2958")));
}

TEST(DoctorOfSteering, noticesTheWrongSign) {
  for (const char* scenario : {"fig4", "slalom_eight"})
    EXPECT_THAT(
        errors(Patient(frontSteered(), scenario).examine(multiplied(-1.0))),
        AllOf(HasSubstr("front_steering has the wrong sign"), HasSubstr("--set steering/front/scale=-1")))
        << scenario;
}

TEST(DoctorOfSteering, noticesADeadSensor) {
  for (const double angle : {0.0, 0.2})
    EXPECT_THAT(errors(Patient(cycab()).examine(onSteering([=](SteeringAngle& steering) {
                  steering.angle = angle;
                  return true;
                }))),
                HasSubstr("front_steering stays at"));
}

TEST(DoctorOfSteering, saysNothingOfAConstantAngleInACircle) {
  Patient patient(cycab(), "circle");
  EXPECT_EQ(errors(patient.examine(onSteering([](SteeringAngle& steering) {
              steering.angle = 0.3;
              return true;
            }))),
            "");
}

TEST(DoctorOfSteering, warnsOfAWrongRatio) {
  EXPECT_THAT(troubles(Patient(cycab()).examine(multiplied(2.0))),
              HasSubstr("WARN   front_steering: by the laser the angles are 0.50"));
}

TEST(DoctorOfSteering, noticesReadingsThatAreNone) {
  int reading = 0;
  EXPECT_THAT(errors(Patient(cycab()).examine(onSteering([&](SteeringAngle& steering) {
                if (++reading % 100 == 0) steering.angle = std::numeric_limits<double>::quiet_NaN();
                return true;
              }))),
              HasSubstr("30 readings are not finite"));
}

/// Both axles measured: each is compared with the way that it goes itself.
TEST(DoctorOfSteering, namesTheAxle) {
  Parameters car = cycab();
  car.vehicle.rear_steering.source = RearSteering::Source::kMeasured;
  const doctor::Examination examination = Patient(car).examine([](SimulatedMessage& message) {
    if (message.topic == "rear_steering") std::get<SteeringAngle>(message.content).angle *= -1.0;
    return true;
  });
  EXPECT_THAT(errors(examination), HasSubstr("rear_steering has the wrong sign"));
  EXPECT_THAT(errors(examination), Not(HasSubstr("front_steering")));
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
