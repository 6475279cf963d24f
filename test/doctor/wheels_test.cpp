// Wheels in each other's place, backwards, still, of the wrong size.

#include "damaged_drive.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <set>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

using Counter = std::int64_t WheelTicks::*;
constexpr std::array<Counter, kWheels> kCounters{&WheelTicks::front_left, &WheelTicks::front_right,
                                                 &WheelTicks::rear_left, &WheelTicks::rear_right};

Counter counterOf(Wheel wheel) { return kCounters[index(wheel)]; }

Damage exchanged(Wheel a, Wheel b) {
  return onWheels([=](WheelTicks& wheels) {
    std::swap(wheels.*counterOf(a), wheels.*counterOf(b));
    return true;
  });
}

Damage multiplied(const std::set<Wheel>& which, double factor) {
  return onWheels([=](WheelTicks& wheels) {
    for (const Wheel wheel : which)
      wheels.*counterOf(wheel) = std::llround(factor * static_cast<double>(wheels.*counterOf(wheel)));
    return true;
  });
}

/// All six exchanges of two wheels, where front and rear wheels roll differently.
TEST(DoctorOfWheels, namesExchangedWheels) {
  for (const char* scenario : {"fig4", "slalom_eight"})
    for (std::size_t a = 0; a < kWheels; ++a)
      for (std::size_t b = a + 1; b < kWheels; ++b) {
        const doctor::Examination examination =
            Patient(frontSteered(), scenario).examine(exchanged(kAllWheels[a], kAllWheels[b]));
        EXPECT_THAT(errors(examination), HasSubstr(std::string("ERROR  ") + name(kAllWheels[a]) + " and " +
                                                   name(kAllWheels[b]) + " are exchanged"))
            << scenario;
        EXPECT_EQ(examination.exitStatus(), 3);
      }
}

/// With rear = -front the wheels of one side turn alike: their exchange changes nothing and raises nothing.
TEST(DoctorOfWheels, saysNothingOfWheelsThatRollAlike) {
  for (const auto& [a, b] :
       {std::pair(Wheel::kFrontLeft, Wheel::kRearLeft), std::pair(Wheel::kFrontRight, Wheel::kRearRight)})
    EXPECT_EQ(troubles(Patient(cycab()).examine(exchanged(a, b))), "") << name(a);
}

TEST(DoctorOfWheels, namesLeftAndRightOfACarThatSteersBothAxles) {
  EXPECT_THAT(errors(Patient(cycab(), "fig4").examine(exchanged(Wheel::kRearLeft, Wheel::kRearRight))),
              HasSubstr("rear_left and rear_right are exchanged"));
}

TEST(DoctorOfWheels, namesTheExchangedWheelsOfARobotThatTurnsOnTheSpot) {
  EXPECT_THAT(
      errors(Patient(differential(), "rectangle").examine(exchanged(Wheel::kRearLeft, Wheel::kRearRight))),
      HasSubstr("rear_left and rear_right are exchanged"));
}

TEST(DoctorOfWheels, namesTheWheelThatCountsBackwards) {
  for (const Wheel wheel : kAllWheels)
    EXPECT_THAT(errors(Patient(frontSteered(), "fig4").examine(multiplied({wheel}, -1.0))),
                AllOf(HasSubstr(std::string("ERROR  ") + name(wheel) + " counts backwards"),
                      HasSubstr(std::string("--set encoders/metres_per_tick/") + name(wheel) + "=-0.0001")));
}

TEST(DoctorOfWheels, saysWhenAllCountBackwards) {
  const std::set<Wheel> all(kAllWheels.begin(), kAllWheels.end());
  EXPECT_THAT(errors(Patient(cycab()).examine(multiplied(all, -1.0))),
              HasSubstr("every wheel counts backwards"));
}

TEST(DoctorOfWheels, namesTheWheelThatStandsStill) {
  for (const Wheel wheel : kAllWheels)
    EXPECT_THAT(errors(Patient(cycab(), "fig4").examine(multiplied({wheel}, 0.0))),
                HasSubstr(std::string("ERROR  ") + name(wheel) + " stands still"));
}

TEST(DoctorOfWheels, namesTheWheelWhoseSizeIsWrong) {
  const std::map<double, const char*> factors{{2.0, "5e-05"}, {0.1, "0.001"}, {10.0, "1e-05"}};
  for (const auto& [factor, zeta] : factors)
    EXPECT_THAT(errors(Patient(cycab(), "fig4").examine(multiplied({Wheel::kFrontRight}, factor))),
                AllOf(HasSubstr("front_right counts "), HasSubstr(std::string(zeta) + " would fit"),
                      Not(HasSubstr("exchanged"))))
        << factor;
}

TEST(DoctorOfWheels, saysWhenAllSizesAreWrong) {
  const std::set<Wheel> all(kAllWheels.begin(), kAllWheels.end());
  EXPECT_THAT(errors(Patient(cycab()).examine(multiplied(all, 10.0))),
              AllOf(HasSubstr("all wheels count "), HasSubstr("divided by 10 would fit")));
}

/// A wheel that is 5 % off is what a calibration is for.
TEST(DoctorOfWheels, leavesTyresToTheCalibration) {
  EXPECT_EQ(troubles(Patient(cycab()).examine(multiplied({Wheel::kRearLeft}, 1.05))), "");
}

/// Without a laser the steering angle says how the car turns.
TEST(DoctorOfWheels, comparesWithTheSteeringWhereThereIsNoLaser) {
  Patient patient(cycab(), "fig4");
  patient.settings().laser_rate = 0.0;
  EXPECT_THAT(errors(patient.examine(exchanged(Wheel::kFrontLeft, Wheel::kFrontRight))),
              AllOf(HasSubstr("front_left and front_right are exchanged, by the steering angle"),
                    HasSubstr("laser_pose (geometry_msgs/PoseWithCovarianceStamped) is missing")));
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
