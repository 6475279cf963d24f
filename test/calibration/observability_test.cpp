// What is observed, how far the others have come, and what the driver is told (docs/reliability.md, row C5).

#include "bs_car_odometry/calibration/observability.hpp"
#include "car_with_laser.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <iostream>

namespace bs_car_odometry::calibration {
namespace {

using simulation::Command;
using systematic::kFrontRight;
using systematic::kFrontTrack;
using systematic::kRearTrack;
using ::testing::HasSubstr;
using ::testing::Not;

CarSettings driveOf(simulation::Scenario scenario, std::vector<std::string> estimate = {"gains"}) {
  CarSettings settings;
  settings.scenario = std::move(scenario);
  settings.parameters.calibration.estimate = std::move(estimate);
  std::cout << "seed " << settings.seed << "\n";
  return settings;
}

Knowledge afterDriving(const CarSettings& settings, double seconds) {
  Calibrator calibrator(settings.parameters);
  CarWithLaser car(settings);
  car.driveUntil(seconds, calibrator);
  return knowledgeOf(calibrator);
}

Command straightAhead(double /*time*/) { return {1.0, 0.0, 0.0}; }

// --- the motion ------------------------------------------------------------------------------------------

TEST(Excitation, turnsAreToldFromTheNoiseOfTheEncoders) {
  const Knowledge straight = afterDriving(driveOf(scenarioOf(100.0, straightAhead)), 50.0);
  // The first half second goes by before the first fix; gains 2 and 1 % wrong bend the path by 0.03 rad/m in
  // the odometry's eyes, half of which the other axle takes back.
  EXPECT_NEAR(straight.excitation.distance, 49.0, 1.5);
  Excitation exact;
  for (int i = 0; i < 5000; ++i) exact.add({0.01, 0.0, (i % 2 == 0 ? 1.0 : -1.0) * 5e-4}, 0.01);
  EXPECT_NEAR(exact.straight, 50.0, 1.0) << "a centimetre turns by 5 % of its length, to and fro";
  EXPECT_EQ(exact.turned_left + exact.turned_right, 0.0);
}

TEST(Excitation, leftRightAndChangesOfSpeedAddUp) {
  Excitation excitation;
  for (int i = 0; i < 100; ++i) excitation.add({0.02, 0.0, 0.01}, 0.02);
  for (int i = 0; i < 100; ++i) excitation.add({0.04, 0.0, -0.03}, 0.02);
  // Up to one leg of a metre is open at the end of a turn, or spans both.
  EXPECT_NEAR(excitation.turned_left, 1.0, 0.5);
  EXPECT_NEAR(excitation.turned_right, 3.0, 0.75);
  EXPECT_NEAR(excitation.speed_change, 1.0, 1e-9) << "the speed at the beginning is no change";
  EXPECT_NEAR(excitation.turn_rate_change, 2.0, 1e-9);
}

TEST(Excitation, turningOnTheSpotCounts) {
  Excitation excitation;
  for (int i = 0; i < 100; ++i) excitation.add({0.0, 0.0, 0.03}, 0.02);
  EXPECT_NEAR(excitation.turned_left, 3.0, 0.2);
}

// --- what is missing -------------------------------------------------------------------------------------

TEST(Missing, nothingWhenEverythingIsObserved) {
  for (const char* scenario : {"fig4", "slalom_eight", "square_loop"}) {
    const CarSettings settings = driveOf(scenarioNamed(scenario));
    const Knowledge knowledge = afterDriving(settings, settings.scenario.duration);
    EXPECT_EQ(missing(knowledge), "") << scenario;
    EXPECT_EQ(whyNotAllObserved(knowledge), "") << scenario;
    for (std::size_t i = 0; i < kCount; ++i) EXPECT_EQ(progress(knowledge, i), 1.0) << parameterName(i);
  }
}

TEST(Missing, allOfItBeforeTheDrive) {
  const CarSettings settings = driveOf(scenarioNamed("fig4"));
  const Knowledge knowledge = knowledgeOf(Calibrator(settings.parameters));
  EXPECT_EQ(missing(knowledge),
            "front/k_r, front/k_l, rear/k_r, rear/k_l: drive 5 m more straight ahead; "
            "front/k_b, rear/k_b: turn 90 degrees more to the right");
  for (std::size_t i = 0; i < kCount; ++i)
    EXPECT_EQ(progress(knowledge, i), knowledge.estimated[i] ? 0.0 : 1.0);
}

TEST(Missing, C5_aStraightDriveAsksForATurn) {
  CarSettings settings = driveOf(scenarioNamed("straight"));
  settings.noise = false;  // its turns to and fro show the track a little
  const Knowledge knowledge = afterDriving(settings, 21.0);
  for (const std::size_t track : {kFrontTrack, kRearTrack}) {
    const auto k = static_cast<Eigen::Index>(track);
    EXPECT_NEAR(knowledge.deviation[k] / knowledge.prior[k], 1.0, 0.01) << parameterName(track);
    EXPECT_LT(progress(knowledge, track), 0.05);
  }
  EXPECT_THAT(missing(knowledge), HasSubstr("front/k_b, rear/k_b: turn "));
  EXPECT_THAT(missing(knowledge), Not(HasSubstr("k_r"))) << "both wheels' gains are observed";
  EXPECT_EQ(whyNotAllObserved(knowledge), "not observed yet: " + missing(knowledge));
}

/// k_b known so badly that it needs more than a bend, and a car that bends one way only.
TEST(Missing, namesTheSideThatWasDrivenLess) {
  for (const double side : {1.0, -1.0}) {
    CarSettings settings = driveOf(scenarioOf(100.0, [side](double time) {
      return Command{1.0, time < 8.0 ? 0.05 * side : 0.0, 0.0};
    }));
    settings.parameters.laser_sigma = {0.2, 0.1};
    const Knowledge knowledge = afterDriving(settings, 20.0);
    ASSERT_FALSE(knowledge.observed(kRearTrack));
    EXPECT_THAT(missing(knowledge), HasSubstr(side > 0.0 ? "to the right" : "to the left"));
  }
}

/// The amount that is asked for falls as the car turns, until nothing is asked any more.
TEST(Missing, theAmountShrinksAndGoes) {
  CarSettings settings = driveOf(scenarioOf(40.0, [](double time) {
    return Command{1.0, 0.2 * std::sin(M_PI * time / 20.0), 0.0};
  }));
  settings.parameters.laser_sigma = {0.1, 0.05};
  Calibrator calibrator(settings.parameters);
  CarWithLaser car(settings);
  std::vector<double> progresses;
  std::string asked;
  for (double time = 2.0; time <= 60.0; time += 2.0) {
    car.driveUntil(time, calibrator);
    const Knowledge knowledge = knowledgeOf(calibrator);
    progresses.push_back(progress(knowledge, kRearTrack));
    std::cout << time << " s: " << progresses.back() << " " << missing(knowledge) << "\n";
    if (!missing(knowledge).empty()) asked = missing(knowledge);
  }
  EXPECT_THAT(asked, HasSubstr("degrees more to the "));
  EXPECT_EQ(missing(knowledgeOf(calibrator)), "");
  EXPECT_TRUE(std::is_sorted(progresses.begin(), progresses.end())) << "information does not get lost";
}

TEST(Missing, asksForWhatShowsTheLaserToo) {
  CarSettings settings = driveOf(scenarioOf(100.0, straightAhead), {"gains", "laser_mount", "time_offset"});
  settings.noise = false;  // it looks like small changes of speed
  const std::string text = missing(afterDriving(settings, 30.0));
  EXPECT_THAT(text, HasSubstr("laser/x, laser/y: turn "));
  EXPECT_THAT(text, HasSubstr("laser/time_offset: change speed"));
  const CarSettings eight = driveOf(scenarioNamed("slalom_eight"), {"gains", "laser_mount", "time_offset"});
  EXPECT_EQ(missing(afterDriving(eight, 60.0)), "");
}

/// A filter that is told of too little noise is sure too soon: the motion holds its progress back.
TEST(Progress, needsMotionAsWellAsDeviation) {
  Knowledge knowledge;
  knowledge.estimated[kFrontTrack] = knowledge.estimated[kFrontRight] = true;
  knowledge.prior.setConstant(0.05);
  knowledge.deviation.setConstant(0.001);
  knowledge.excitation.distance = 1.0;
  EXPECT_EQ(progress(knowledge, kFrontTrack), 0.0);
  EXPECT_EQ(progress(knowledge, kFrontRight), 0.5);
  knowledge.excitation.turned_left = 1.0;
  EXPECT_EQ(progress(knowledge, kFrontTrack), 1.0);
}

// --- gains that cannot be ----------------------------------------------------------------------------------

TEST(ImplausibleGains, C7_namesTheGainAndWhatToCheck) {
  ParameterVector values = ParameterVector::Ones();
  ParameterMask observed{};
  observed[systematic::kRearRight] = observed[kRearTrack] = true;
  EXPECT_EQ(implausibleGains(values, observed), "");
  values[kFrontRight] = 2.0;
  EXPECT_EQ(implausibleGains(values, observed), "") << "what was not observed is not believed";
  values[kRearTrack] = 0.79;
  EXPECT_THAT(implausibleGains(values, observed), HasSubstr("rear/k_b = 0.79: outside"));
  EXPECT_THAT(implausibleGains(values, observed), HasSubstr("vehicle/track"));
  values[kRearTrack] = 1.0;
  values[systematic::kRearRight] = 0.5;
  EXPECT_THAT(implausibleGains(values, observed), HasSubstr("radius"));
  EXPECT_THAT(implausibleGains(values, observed), HasSubstr("ticks per turn"));
  EXPECT_THAT(implausibleGains(values, observed), Not(HasSubstr("k_b")));
}

}  // namespace
}  // namespace bs_car_odometry::calibration
