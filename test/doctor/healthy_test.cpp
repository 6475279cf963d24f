// A healthy bag gives no finding, whatever the car drives.

#include "damaged_drive.hpp"

#include <gmock/gmock.h>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::HasSubstr;

struct Case {
  const char* name;
  const char* scenario;
  Parameters (*car)();
};

class Healthy : public ::testing::TestWithParam<Case> {};

/// Ten drives each: with the gains 2, 1 and 3 % off as the scenarios have them, and full noise.
TEST_P(Healthy, givesNoFalseFinding) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Patient patient(GetParam().car(), GetParam().scenario);
    patient.settings().seed = seed;
    const doctor::Examination examination = patient.examine();
    EXPECT_EQ(troubles(examination), "") << "seed " << seed;
    EXPECT_EQ(examination.exitStatus(), 0) << "seed " << seed << "\n" << report(examination);
  }
}

INSTANTIATE_TEST_SUITE_P(Drives, Healthy,
                         ::testing::Values(Case{"fig4Cycab", "fig4", cycab},
                                           Case{"fig4FrontSteered", "fig4", frontSteered},
                                           Case{"slalomCycab", "slalom_eight", cycab},
                                           Case{"slalomFrontSteered", "slalom_eight", frontSteered},
                                           Case{"squareLoop", "square_loop", cycab},
                                           Case{"rectangleOnTheSpot", "rectangle", differential}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(HealthyBag, withMeasuredRearSteeringIsInOrder) {
  Parameters car = cycab();
  car.vehicle.rear_steering.source = RearSteering::Source::kMeasured;
  const doctor::Examination examination = Patient(car).examine();
  EXPECT_EQ(troubles(examination), "");
  EXPECT_THAT(report(examination), HasSubstr("rear_steering: "));
}

TEST(HealthyBag, sixteenBitCountersThatWrapAreInOrder) {
  Parameters car = cycab();
  car.vehicle.counter_bits = 16;
  const doctor::Examination examination = Patient(car).examine(onWheels([](WheelTicks& wheels) {
    for (std::int64_t* counter :
         {&wheels.front_left, &wheels.front_right, &wheels.rear_left, &wheels.rear_right})
      *counter &= 0xffff;
    return true;
  }));
  EXPECT_EQ(troubles(examination), "");
  // 60 m are 600,000 ticks: nine wraps a wheel, 36 or more with the gains' few per cent.
  EXPECT_THAT(report(examination), HasSubstr("counters: 36 wraps"));
}

TEST(HealthyBag, aLaserMountedElsewhereIsInOrderWhenConfigured) {
  Parameters car = cycab();
  car.laser.x = 0.8;
  car.laser.y = -0.2;
  car.laser.yaw = 3.1;
  EXPECT_EQ(troubles(Patient(car).examine()), "");
}

TEST(HealthyBag, aLaserFrameThatTfKnowsIsInOrder) {
  Parameters car = cycab();
  car.laser.frame = "laser";
  EXPECT_EQ(troubles(Patient(car).examine()), "");
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
