#include "bs_car_odometry/simulation/simulated_car.hpp"

#include "test_vehicles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <vector>

namespace bs_car_odometry::simulation {
namespace {

/// Of everything but what the test is about.
NoiseModel quiet() {
  NoiseModel noise;
  noise.wheel = 0.0;
  noise.steering = {0.0, 0.1};
  noise.lateral = 0.0;
  noise.rear_law = 0.0;
  return noise;
}

constexpr int kDrives =
    4000;  // relative standard error of a variance 2.2 %, so the tolerances are four of them
constexpr double kTolerance = 0.09;

/// Mean square of `value` over drives with the seeds 0 to kDrives - 1, 4 s at 1 m/s straight ahead.
double meanSquare(const Vehicle& vehicle, const NoiseModel& noise, double rate, Drivetrain drivetrain,
                  const Scenario& scenario, const std::function<double(SimulatedCar&, int)>& value) {
  double sum = 0.0;
  for (int seed = 0; seed < kDrives; ++seed) {
    SimulationOptions options;
    options.seed = static_cast<std::uint64_t>(seed);
    options.substep = 0.01;
    options.drivetrain = drivetrain;
    SimulatedCar car(vehicle, asConfigured(vehicle), noise, scenario, options);
    const int readings = static_cast<int>(std::lround(rate * scenario.duration));
    double last = 0.0;
    for (int i = 1; i <= readings; ++i) {
      car.advanceTo(i / rate);
      last += value(car, i);
    }
    sum += last * last;
  }
  return sum / kDrives;
}

Scenario fourMetres() { return constantDrive(4.0, 1.0, 0.0); }

TEST(SimulatedCar, countersWithoutNoiseAreTheTrueTravelsOfTheNominalCar) {
  const Vehicle vehicle = cycab();
  SimulatedCar car(vehicle, withScenarioGains(vehicle), std::nullopt, makeScenario("fig4", vehicle));
  car.advanceTo(15.0);
  const PerWheel<std::int64_t> counters = car.readCounters();
  EXPECT_EQ(counters[Wheel::kRearRight], std::llround(20.053184258 / 1.02e-4));
  EXPECT_EQ(counters[Wheel::kRearLeft], std::llround(18.033382088 / 0.99e-4));
}

TEST(SimulatedCar, countersStartWhereTheyAreToldAndWrap) {
  Vehicle vehicle = cycab();
  vehicle.counter_bits = 16;
  SimulationOptions options;
  options.counter_start = {{0, 30000, -5, 7}};
  SimulatedCar car(vehicle, asConfigured(vehicle), std::nullopt, fourMetres(), options);
  EXPECT_EQ(car.readCounters(), options.counter_start);
  car.advanceTo(1.0);
  EXPECT_EQ(car.readCounters(), (PerWheel<std::int64_t>{{10000, 40000 - 65536, 9995, 10007}}));
}

// reading = (angle - offset)/scale, each axle with its own.
TEST(SimulatedCar, steeringReadingUndoesScaleAndOffset) {
  const Vehicle vehicle = cycab();
  TrueParameters truth = asConfigured(vehicle);
  truth.steering.front = {2.0, 0.05};
  truth.steering.rear = {0.5, -0.01};
  SimulatedCar car(vehicle, truth, std::nullopt, constantDrive(1.0, 1.0, 0.3));
  car.advanceTo(0.5);
  EXPECT_NEAR(car.readSteering(Axle::kFront), 0.125, 1e-15);
  EXPECT_NEAR(car.readSteering(Axle::kRear), -0.58, 1e-15);
}

TEST(SimulatedCar, laserSeesItsMount) {
  const Vehicle vehicle = cycab();
  SimulationOptions options;
  options.initial_pose = {1.0, 2.0, 1.5707963267948966};
  SimulatedCar car(vehicle, asConfigured(vehicle), std::nullopt, fourMetres(), options);
  const Pose pose = car.readLaser({0.5, 0.1, 0.2}, 0.0, 0.0);
  EXPECT_NEAR(pose.x, 0.9, 1e-15);
  EXPECT_NEAR(pose.y, 2.5, 1e-15);
  EXPECT_NEAR(pose.yaw, 1.7707963267948966, 1e-15);
}

TEST(SimulatedCar, laserErrorsHaveTheirStandardDeviations) {
  const Vehicle vehicle = cycab();
  SimulatedCar car(vehicle, asConfigured(vehicle), std::nullopt, fourMetres());
  constexpr int kReadings = 20000;  // relative standard error 1 %
  Pose variance;
  for (int i = 0; i < kReadings; ++i) {
    const Pose pose = car.readLaser({}, 0.02, 0.005);
    variance.x += pose.x * pose.x / kReadings;
    variance.y += pose.y * pose.y / kReadings;
    variance.yaw += pose.yaw * pose.yaw / kReadings;
  }
  EXPECT_NEAR(variance.x / 4e-4, 1.0, 0.04);
  EXPECT_NEAR(variance.y / 4e-4, 1.0, 0.04);
  EXPECT_NEAR(variance.yaw / 2.5e-5, 1.0, 0.04);
}

// --- seeds ---------------------------------------------------------------------------------------------

std::vector<double> readings(std::uint64_t seed, bool steering_too) {
  const Vehicle vehicle = cycab();
  SimulationOptions options;
  options.seed = seed;
  SimulatedCar car(vehicle, withScenarioGains(vehicle), NoiseModel{}, makeScenario("fig4", vehicle), options);
  std::vector<double> values;
  for (int i = 1; i <= 750; ++i) {
    car.advanceTo(0.02 * i);
    for (std::int64_t counter : car.readCounters().values) values.push_back(static_cast<double>(counter));
    if (steering_too) car.readSteering(Axle::kFront);
  }
  return values;
}

TEST(SimulatedCar, theSameSeedIsTheSameDrive) {
  EXPECT_EQ(readings(5, true), readings(5, true));
  EXPECT_NE(readings(5, true), readings(6, true));
}

TEST(SimulatedCar, aSensorDoesNotDisturbAnother) { EXPECT_EQ(readings(5, true), readings(5, false)); }

// --- noise ---------------------------------------------------------------------------------------------

TEST(SimulatedCarNoise, wheelsHaveTheirVariancePerMetreAtEveryRate) {
  NoiseModel noise = quiet();
  noise.wheel = 0.005;
  for (double rate : {10.0, 100.0})
    for (Wheel wheel : {Wheel::kFrontLeft, Wheel::kRearRight}) {
      double before = 0.0;
      const double variance =
          meanSquare(cycab(), noise, rate, Drivetrain::kSteered, fourMetres(), [&](SimulatedCar& car, int i) {
            car.readCounters();
            const double error = car.measuredTravel(wheel) - car.trueTravel(wheel);
            const double step = i == 1 ? error : error - before;
            before = error;
            return step;
          });
      EXPECT_NEAR(variance / (0.005 * 0.005 * 4.0), 1.0, kTolerance)
          << rate << " Hz, seeds 0 to " << kDrives - 1;
    }
}

TEST(SimulatedCarNoise, wheelsAreIndependent) {
  NoiseModel noise = quiet();
  noise.wheel = 0.005;
  const double variance =
      meanSquare(cycab(), noise, 0.25, Drivetrain::kSteered, fourMetres(), [](SimulatedCar& car, int) {
        car.readCounters();
        return car.measuredTravel(Wheel::kRearRight) - car.measuredTravel(Wheel::kRearLeft);
      });
  EXPECT_NEAR(variance / (2.0 * 0.005 * 0.005 * 4.0), 1.0, kTolerance);
}

// Correlation of what each sensor adds in one reading, over 4000 seeds: standard error 0.016.
TEST(SimulatedCarNoise, steeringAndWheelsAreIndependent) {
  NoiseModel noise = quiet();
  noise.wheel = 0.005;
  noise.steering = {0.003, 100.0};
  PerWheel<double> correlation;
  double between_axles = 0.0;
  for (int seed = 0; seed < kDrives; ++seed) {
    SimulationOptions options;
    options.seed = static_cast<std::uint64_t>(seed);
    options.substep = 1.0;
    SimulatedCar car(cycab(), asConfigured(cycab()), noise, fourMetres(), options);
    car.advanceTo(1.0);
    car.readCounters();
    const double front = car.readSteering(Axle::kFront) / 0.003;
    const double rear = car.readSteering(Axle::kRear) / 0.003;
    between_axles += front * rear / kDrives;
    for (Wheel wheel : kAllWheels) {
      const double error = (car.measuredTravel(wheel) - car.trueTravel(wheel)) / 0.005;
      correlation[wheel] += (axleOf(wheel) == Axle::kFront ? front : rear) * error / kDrives;
    }
  }
  EXPECT_NEAR(between_axles, 0.0, 0.065);
  for (Wheel wheel : kAllWheels) EXPECT_NEAR(correlation[wheel], 0.0, 0.065) << name(wheel);
}

// Int error ds over D = 4 m has variance std^2 l D (1 - l/(3D)), whatever the rate.
TEST(SimulatedCarNoise, steeringHasItsVariancePerMetreAtEveryRate) {
  NoiseModel noise = quiet();
  noise.steering = {0.003, 0.1};
  Vehicle vehicle = cycab();
  vehicle.rear_steering.source = RearSteering::Source::kMeasured;
  for (double rate : {2.0, 10.0, 100.0})
    for (Axle axle : kAllAxles) {
      const double variance =
          meanSquare(vehicle, noise, rate, Drivetrain::kSteered, fourMetres(),
                     [&](SimulatedCar& car, int) { return car.readSteering(axle) / rate; });
      EXPECT_NEAR(variance / (9e-6 * 0.1 * 4.0 * (1.0 - 0.1 / 12.0)), 1.0, kTolerance) << rate << " Hz";
    }
}

TEST(SimulatedCarNoise, aSingleReadingHasTheVarianceOfItsTravel) {
  NoiseModel noise = quiet();
  noise.steering = {0.003, 0.1};
  const auto last = [](double rate) {
    return [rate](SimulatedCar& car, int i) {
      const double reading = car.readSteering(Axle::kFront);
      return i == std::lround(4.0 * rate) ? reading : 0.0;
    };
  };
  const double fine = meanSquare(cycab(), noise, 100.0, Drivetrain::kSteered, fourMetres(), last(100.0));
  EXPECT_NEAR(fine / (9e-6 * (1.0 - 0.1 / 3.0)), 1.0, kTolerance);  // d = l/10
  const double coarse = meanSquare(cycab(), noise, 1.0, Drivetrain::kSteered, fourMetres(), last(1.0));
  EXPECT_NEAR(coarse / (9e-6 * 0.1 * (1.0 - 0.1 / 3.0)), 1.0, kTolerance);  // d = 10 l
}

// Turning on the spot is travel too: d = (|S_r| + |S_l|)/2, the wheels' 4 m here.
TEST(SimulatedCarNoise, turningOnTheSpotIsTravelForTheRearAxle) {
  NoiseModel noise = quiet();
  noise.steering = {0.003, 0.1};
  noise.lateral = 0.0005;
  const Scenario spin = constantDrive(4.0, 0.0, 0.0, 5.0);  // half a track of 0.2 m
  const double steering =
      meanSquare(robot(), noise, 10.0, Drivetrain::kDifferential, spin,
                 [](SimulatedCar& car, int) { return car.readSteering(Axle::kRear) / 10.0; });
  EXPECT_NEAR(steering / (9e-6 * 0.1 * 4.0 * (1.0 - 0.1 / 12.0)), 1.0, kTolerance);
  const auto away = [](SimulatedCar& car, int i) {
    return i < 4 ? 0.0 : std::hypot(car.truePose().x, car.truePose().y);
  };
  const double slip = meanSquare(robot(), noise, 1.0, Drivetrain::kDifferential, spin, away);
  EXPECT_NEAR(slip / (0.0005 * 0.0005 * 4.0), 1.0, kTolerance);
}

TEST(SimulatedCarNoise, nothingGrowsAtAStandstill) {
  NoiseModel noise;
  noise.steering.angle = 0.003;
  const Vehicle vehicle = cycab();
  SimulatedCar car(vehicle, asConfigured(vehicle), noise, constantDrive(10.0, 0.0, 0.2));
  car.advanceTo(0.02);
  const PerWheel<std::int64_t> counters = car.readCounters();
  const double angle = car.readSteering(Axle::kFront);
  for (int i = 2; i <= 500; ++i) {
    car.advanceTo(0.02 * i);
    ASSERT_EQ(car.readCounters(), counters);
    ASSERT_EQ(car.readSteering(Axle::kFront), angle);
  }
  EXPECT_EQ(car.truePose().x, 0.0);
  EXPECT_EQ(car.truePose().yaw, 0.0);
}

double atTheEnd(int i, double value) { return i == 4 ? value : 0.0; }

// Straight ahead the axles slip apart: Var yaw = 2 lateral^2 D / L^2. The middle of the car moves by their
// mean and by its heading: Var y = lateral^2 D/2 + 2 lateral^2 D^3/(3 L^2).
TEST(SimulatedCarNoise, sideSlipMovesTheTruePath) {
  NoiseModel noise = quiet();
  noise.lateral = 0.002;
  const double yaw = meanSquare(cycab(), noise, 1.0, Drivetrain::kSteered, fourMetres(),
                                [](SimulatedCar& car, int i) { return atTheEnd(i, car.truePose().yaw); });
  EXPECT_NEAR(yaw / (2.0 * 4e-6 * 4.0 / 1.44), 1.0, kTolerance);
  const double y = meanSquare(cycab(), noise, 1.0, Drivetrain::kSteered, fourMetres(),
                              [](SimulatedCar& car, int i) { return atTheEnd(i, car.truePose().y); });
  EXPECT_NEAR(y / (4e-6 * 2.0 + 2.0 * 4e-6 * 64.0 / (3.0 * 1.44)), 1.0, kTolerance);
}

// The encoders see the yaw that the slip brings: S_r - S_l = B yaw, so one axle's odometry has nothing to
// complain of.
TEST(SimulatedCarNoise, wheelsSeeTheYawOfTheSlip) {
  NoiseModel noise = quiet();
  noise.lateral = 0.002;
  const Vehicle vehicle = cycab();
  SimulatedCar car(vehicle, asConfigured(vehicle), noise, fourMetres());
  car.advanceTo(4.0);
  EXPECT_GT(std::abs(car.truePose().yaw), 1e-4);
  EXPECT_NEAR(car.trueTravel(Wheel::kRearRight) - car.trueTravel(Wheel::kRearLeft), 1.2 * car.truePose().yaw,
              1e-12);
}

// yaw = -Int error ds / L: variance std^2 l D (1 - l/(3D)) / L^2.
TEST(SimulatedCarNoise, rearLawErrorTurnsTheCar) {
  NoiseModel noise = quiet();
  noise.rear_law = 0.004;
  const auto yaw_at_end = [](SimulatedCar& car, int i) { return atTheEnd(i, car.truePose().yaw); };
  const double yaw = meanSquare(cycab(), noise, 1.0, Drivetrain::kSteered, fourMetres(), yaw_at_end);
  EXPECT_NEAR(yaw / (1.6e-5 * 0.1 * 4.0 * (1.0 - 0.1 / 12.0) / 1.44), 1.0, kTolerance);

  Vehicle measured = cycab();
  measured.rear_steering.source = RearSteering::Source::kMeasured;
  EXPECT_EQ(meanSquare(measured, noise, 1.0, Drivetrain::kSteered, fourMetres(), yaw_at_end), 0.0);
}

/// The largest error of one metre, taken as one step, over the seeds from 0.
template <typename Error>
double largestError(const NoiseModel& noise, const Error& error) {
  double largest = 0.0;
  for (int seed = 0; seed < kDrives; ++seed) {
    SimulationOptions options;
    options.seed = static_cast<std::uint64_t>(seed);
    options.substep = 1.0;
    SimulatedCar car(cycab(), asConfigured(cycab()), noise, fourMetres(), options);
    car.advanceTo(1.0);
    largest = std::max(largest, std::abs(error(car)));
  }
  return largest;
}

// Uniform errors fill their bounds and keep them; a Gaussian of their standard deviation would leave them by
// far.
TEST(SimulatedCarNoise, everyErrorComesFromItsDistribution) {
  NoiseModel noise = quiet();
  noise.wheel = Distribution::uniform(0.01);
  noise.steering = {Distribution::uniform(0.02), 100.0};
  noise.rear_law = Distribution::uniform(0.03);
  const double wheel = largestError(noise, [](SimulatedCar& car) {
    car.readCounters();
    const double travel = car.trueTravel(Wheel::kFrontLeft);
    return (car.measuredTravel(Wheel::kFrontLeft) - travel) / std::sqrt(travel);
  });
  // 4000 seeds: that none comes within 1 % of the bound has a chance of 1e-17.
  EXPECT_LE(wheel, 0.01 * (1.0 + 1e-12)) << "a difference of numbers near one";
  EXPECT_GT(wheel, 0.01 * 0.99);
  const double steering =
      largestError(noise, [](SimulatedCar& car) { return car.readSteering(Axle::kFront); });
  EXPECT_LE(steering, 0.02);
  EXPECT_GT(steering, 0.02 * 0.99);
  const double law = largestError(
      noise, [](SimulatedCar& car) { return car.trueAngle(Axle::kRear) + car.trueAngle(Axle::kFront); });
  EXPECT_LE(law, 0.03 * (1.0 + 1e-12)) << "an angle from its sine and cosine";
  EXPECT_GT(law, 0.03 * 0.99);
}

// yaw = (n_f - n_r) / L of two independent slips: a triangular distribution, within 10 % of its ends once in
// 100.
TEST(SimulatedCarNoise, sideSlipComesFromItsDistribution) {
  NoiseModel noise = quiet();
  noise.lateral = Distribution::uniform(0.006);
  const double yaw = largestError(noise, [](SimulatedCar& car) { return car.truePose().yaw; });
  EXPECT_LE(yaw, 2.0 * 0.006 / 1.2);
  EXPECT_GT(yaw, 2.0 * 0.006 / 1.2 * 0.9);
}

}  // namespace
}  // namespace bs_car_odometry::simulation
