// The odometry over noise-free drives, model and car alike: what is left is the sampling of steering and
// wheels.
#include "cars.hpp"
#include "drive.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace bs_car_odometry::drives {
namespace {

struct Car {
  const char* name;
  Vehicle vehicle;
};

std::vector<Car> carsWith(AxleGeometry geometry) {
  return {{"cycab", cycab(geometry)},
          {"hub offset", cycabWithHubs(geometry)},
          {"unequal tracks, base_link midway", unevenCycab(geometry)},
          {"measured rear angle", cycabWithRearSensor(geometry)},
          {"front steering", ordinaryCar(geometry)}};
}

/// Every car with both axle geometries and every choice of axles; the differential robot with its only one.
template <typename Check>
void forEveryOdometry(const Check& check) {
  for (const AxleGeometry geometry : {AxleGeometry::kAckermann, AxleGeometry::kPivot})
    for (const Car& car : carsWith(geometry))
      for (const AxleSelection axles : {AxleSelection::kBoth, AxleSelection::kFront, AxleSelection::kRear}) {
        SCOPED_TRACE(std::string(car.name) + ", " + name(geometry) + ", axles " + name(axles));
        check(car.vehicle, axles);
      }
  SCOPED_TRACE("differential robot");
  check(differentialRobot(), AxleSelection::kRear);
}

/// End error [m], printed and returned.
double endError(const Vehicle& vehicle, AxleSelection axles, const DriveSettings& settings) {
  return departure(odometryOf(vehicle, axles), record(vehicle, settings)).at_end;
}

DriveSettings settingsFor(const char* scenario, double rate, AxleSelection axles) {
  DriveSettings settings;
  settings.scenario = scenario;
  settings.rate = rate;
  settings.axles = axles;
  return settings;
}

TEST(NoiseFree, sixtyMetresOfCircleEndWithinAMillimetre) {
  double worst = 0.0;
  forEveryOdometry([&](const Vehicle& vehicle, AxleSelection axles) {
    const double error = endError(vehicle, axles, settingsFor("circle", 20.0, axles));
    EXPECT_LE(error, 1e-3);
    worst = std::max(worst, error);
  });
  std::printf("worst end error: %.6f m\n", worst);
}

TEST(NoiseFree, sixtyMetresOfSlalomEndWithinFiveMillimetres) {
  double worst = 0.0;
  forEveryOdometry([&](const Vehicle& vehicle, AxleSelection axles) {
    const double error = endError(vehicle, axles, settingsFor("slalom_eight", 20.0, axles));
    EXPECT_LE(error, 5e-3);
    worst = std::max(worst, error);
  });
  std::printf("worst end error: %.6f m\n", worst);
}

TEST(NoiseFree, fig4At50HzEndsWithinAThousandthOfAPercent) {
  constexpr double kDistance = 19.035;  // m
  double worst = 0.0;
  forEveryOdometry([&](const Vehicle& vehicle, AxleSelection axles) {
    const double error = endError(vehicle, axles, settingsFor("fig4", 50.0, axles));
    EXPECT_LE(error, 1e-5 * kDistance);
    worst = std::max(worst, error);
  });
  std::printf("worst end error: %.6f m, %.5f %% of the distance\n", worst, 100.0 * worst / kDistance);
}

}  // namespace
}  // namespace bs_car_odometry::drives
