// Drives with a faulty sensor: it is named, left out and taken back, and the odometry goes on without it as
// well as its covariance says (docs/reliability.md, rows E3, E7 to E9, S6).

#include "cars.hpp"
#include "damage.hpp"

#include "bs_car_odometry/laboratory/chi_square.hpp"
#include "bs_car_odometry/laboratory/error.hpp"
#include "bs_car_odometry/laboratory/parallel.hpp"

#include "support/figure.hpp"

#include <gmock/gmock.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <random>
#include <tuple>

namespace bs_car_odometry::drives {
namespace {

using laboratory::DriveSettings;
using ::testing::Le;

constexpr double kTick = 1e-4;      // m
constexpr double kFault = 20.0;     // s, when a fault begins, in a turn of every scenario used
constexpr double kNamedWithin = 1;  // s
constexpr std::uint64_t kFirstSeed = 500;

OdometryConfiguration odometryOf(const Vehicle& vehicle) {
  OdometryConfiguration configuration;
  configuration.vehicle = vehicle;
  return configuration;
}

DriveSettings driveOf(const OdometryConfiguration& odometry, const char* scenario, std::uint64_t seed,
                      double speed_factor = 1.0) {
  DriveSettings settings;
  settings.scenario = scenario;
  settings.rate = 50.0;
  settings.substep = 0.01;
  settings.speed_factor = speed_factor;
  settings.noise = odometry.noise;
  settings.draw_gains = odometry.noise.systematic;
  settings.seed = kFirstSeed + seed;
  return settings;
}

/// What became of a drive.
struct Outcome {
  SensorReport sensors;                               ///< at its end
  std::array<std::optional<double>, kSensors> named;  ///< [s] when each was first said to have its fault
  OdometryEstimate estimate;
  double distance{0.0};
};

Outcome run(const OdometryConfiguration& odometry, const std::vector<Sample>& drive) {
  Outcome outcome;
  laboratory::replay(odometry, drive, [&](const Sample& sample, const OdometryUpdate& update) {
    outcome.sensors = update.report.sensors;
    for (std::size_t i = 0; i < kSensors; ++i) {
      const SensorFault fault = outcome.sensors.sensors[i].fault;
      if (fault == SensorFault::kNone || fault == SensorFault::kUndecided) continue;
      if (!outcome.named[i]) outcome.named[i] = sample.time;
    }
    outcome.estimate = update.estimate;
    outcome.distance = update.report.distance;
  });
  return outcome;
}

/// The sensors that are left out at the end.
std::vector<std::size_t> leftOut(const Outcome& outcome) {
  std::vector<std::size_t> sensors;
  for (std::size_t i = 0; i < kSensors; ++i)
    if (outcome.sensors.sensors[i].fault != SensorFault::kNone) sensors.push_back(i);
  return sensors;
}

double positionError(const Outcome& outcome, const std::vector<Sample>& drive) {
  return laboratory::poseError(outcome.estimate, drive.back().truth).head<2>().norm();
}

double rootMeanSquare(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// --- E7: an encoder is stuck -----------------------------------------------------------------------------

class EachWheel : public ::testing::TestWithParam<Wheel> {};

TEST_P(EachWheel, E7_frozen_counter_is_named_within_a_second) {
  const OdometryConfiguration odometry = odometryOf(cycab(AxleGeometry::kAckermann, kTick));
  const std::size_t wheel = sensor(GetParam());
  double latest = 0.0;
  for (const double speed : {0.5, 1.0, 2.0, 5.0}) {  // the scenario is one of 1 m/s
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      std::vector<Sample> drive = record(odometry.vehicle, driveOf(odometry, "slalom_eight", seed, speed));
      scaleTravel(drive, GetParam(), 0.0, kFault);
      const Outcome outcome = run(odometry, drive);
      SCOPED_TRACE(::testing::Message() << speed << " m/s, seed " << seed);
      ASSERT_TRUE(outcome.named[wheel]);
      EXPECT_THAT(*outcome.named[wheel] - kFault, Le(kNamedWithin));
      EXPECT_GT(*outcome.named[wheel], kFault);
      EXPECT_THAT(leftOut(outcome), ::testing::ElementsAre(wheel));
      EXPECT_EQ(outcome.sensors.sensors[wheel].fault, SensorFault::kStuck);
      latest = std::max(latest, *outcome.named[wheel] - kFault);
    }
  }
  recordFigure("frozen: named after %.2f s at the latest", latest);
}

/// Noise only: what p(A) does to the pose is the same with three wheels and with four.
TEST_P(EachWheel, E7_goes_on_with_three_wheels) {
  constexpr std::size_t kDrives = 60;
  OdometryConfiguration odometry = odometryOf(cycab(AxleGeometry::kAckermann, kTick));
  odometry.noise.systematic = {0.0, 0.0, 0.0, 0.0};
  std::vector<double> healthy(kDrives);
  std::vector<double> without(kDrives);
  double nees = 0.0;
  for (std::size_t i = 0; i < kDrives; ++i) {
    DriveSettings settings = driveOf(odometry, "slalom_eight", i);
    settings.duration = 100.0;  // at 1 m/s, and the wheel is out for all of it
    std::vector<Sample> drive = record(odometry.vehicle, settings);
    healthy[i] = positionError(run(odometry, drive), drive);
    scaleTravel(drive, GetParam(), 0.0);
    const Outcome outcome = run(odometry, drive);
    without[i] = positionError(outcome, drive);
    nees += laboratory::exponentialNees(outcome.estimate, drive.back().truth) / kDrives;
  }
  recordFigure("drift over 100 m %.2f times that with the wheel",
               rootMeanSquare(without) / rootMeanSquare(healthy));
  EXPECT_LE(rootMeanSquare(without), 1.5 * rootMeanSquare(healthy));
  EXPECT_TRUE(laboratory::meanInterval(3.0, kDrives).holds(nees)) << nees;
}

/// Straight ahead at the speed of each time, with the noise of the wheels, and counters that begin anywhere
/// within a tick.
std::vector<Sample> straight(const OdometryConfiguration& odometry, double rate, double duration,
                             std::uint64_t seed, const std::function<double(double)>& speed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  std::vector<Sample> drive(1);
  PerWheel<double> travels;
  for (const Wheel wheel : kAllWheels)
    travels[wheel] = uniform(random) * odometry.vehicle.metres_per_tick[wheel];
  for (int i = 1; i <= duration * rate; ++i) {
    Sample sample = drive.back();
    sample.time = i / rate;
    const double way = speed(sample.time) / rate;
    sample.truth.x += way;
    const double sigma = std::sqrt(odometry.noise.wheel.variance() * std::abs(way));
    for (const Wheel wheel : kAllWheels) {
      travels[wheel] += way + sigma * normal(random);
      sample.ticks[wheel] = std::llround(travels[wheel] / odometry.vehicle.metres_per_tick[wheel]);
    }
    drive.push_back(sample);
  }
  return drive;
}

/// Of a calibrated car with good tyres, which soon takes back a wheel that is right.
OdometryConfiguration exactOdometry(double tick = kTick) {
  OdometryConfiguration odometry = odometryOf(cycab(AxleGeometry::kAckermann, tick));
  odometry.noise.wheel = Distribution(0.002);
  odometry.noise.systematic = {0.0, 0.0, 0.0, 0.0};
  return odometry;
}

/// A motorway: by a thousandth faster each second, then slower again.
double motorway(double time) { return 20.0 * (1.0 + 0.001 * std::min(time, 40.0 - time)); }

/// Long before it is 2 % wrong, which is the least that a wheel is believed to be wrong by otherwise.
TEST_P(EachWheel, E7_frozen_speed_is_named_when_the_car_has_changed_its_own_by_a_percent) {
  const OdometryConfiguration odometry = exactOdometry();
  const std::size_t wheel = sensor(GetParam());
  double earliest = 40.0;
  double latest = 0.0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    std::vector<Sample> drive = straight(odometry, 50.0, 40.0, seed, motorway);
    EXPECT_EQ(run(odometry, drive).sensors.exclusions, 0u) << "nothing is wrong yet, seed " << seed;
    freezeSpeed(drive, GetParam(), 5.0);
    const Outcome outcome = run(odometry, drive);
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    ASSERT_TRUE(outcome.named[wheel]);
    earliest = std::min(earliest, *outcome.named[wheel] - 5.0);
    latest = std::max(latest, *outcome.named[wheel] - 5.0);
    EXPECT_THAT(leftOut(outcome), ::testing::ElementsAre(wheel));
    EXPECT_EQ(outcome.sensors.sensors[wheel].fault, SensorFault::kFrozen);
    EXPECT_EQ(outcome.sensors.exclusions, 1u) << "and not taken back: it is right only in passing";
    EXPECT_LT(laboratory::exponentialNees(outcome.estimate, drive.back().truth), 16.3) << "0.1 %";
  }
  // A percent after 10 s, give or take the noise of the two stretches that are compared: each is 0.14 % of
  // its travel, and the slowest of three wheels counts.
  EXPECT_GE(earliest, 8.0);
  EXPECT_LE(latest, 12.0);
  recordFigure("frozen speed: named after %.1f s in which the car's changes by 0.1 %% a second", latest);
}

TEST_P(EachWheel, E7_frozen_speed_is_told_from_a_reversed_or_a_stuck_counter) {
  const OdometryConfiguration odometry = exactOdometry();
  for (const double change : {-2.0, 8.0}) {  // m/s: the car reverses, or goes far faster
    std::vector<Sample> drive = straight(odometry, 50.0, 30.0, 1, [change](double time) {
      return 1.0 + change * std::clamp((time - 10.0) / 10.0, 0.0, 1.0);
    });
    freezeSpeed(drive, GetParam(), 5.0);
    const Outcome outcome = run(odometry, drive);
    EXPECT_THAT(leftOut(outcome), ::testing::ElementsAre(sensor(GetParam()))) << change;
    EXPECT_EQ(outcome.sensors[GetParam()].fault, SensorFault::kFrozen) << change;
  }
}

/// One that comes when the car is nearly as fast as the frozen wheel again, and stays so.
TEST_P(EachWheel, E7_a_calibration_does_not_take_back_a_frozen_wheel) {
  const OdometryConfiguration odometry = exactOdometry();
  std::vector<Sample> drive = straight(odometry, 50.0, 40.0, 2, motorway);
  freezeSpeed(drive, GetParam(), 5.0);
  OdometryPipeline pipeline(odometry);
  SensorFault fault = SensorFault::kNone;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    if (i == 33 * 50) pipeline.setCalibration(pipeline.calibration());
    fault = laboratory::step(pipeline, drive[i]).report.sensors[GetParam()].fault;
  }
  EXPECT_EQ(fault, SensorFault::kFrozen);
}

/// All wheels keep the same speed here, and none is frozen.
TEST(Faults, E7_wheels_of_a_car_that_keeps_its_speed_are_not_frozen) {
  const OdometryConfiguration odometry = odometryOf(cycab(AxleGeometry::kAckermann, kTick));
  DriveSettings settings = driveOf(odometry, "circle", 0);
  settings.noise.reset();
  settings.draw_gains.reset();
  std::vector<Sample> drive = record(odometry.vehicle, settings);
  EXPECT_EQ(run(odometry, drive).sensors.exclusions, 0u);
  offsetAngle(drive, Axle::kFront, 0.1, kFault);
  EXPECT_THAT(leftOut(run(odometry, drive)), ::testing::ElementsAre(sensor(Axle::kFront)));
}

/// Counters of 2 and 10 cm, as of an anti-lock brake: a wheel may say the same for long. Creeping, standing,
/// gentle and hard acceleration, backwards.
TEST(Faults, E7_wheels_with_coarse_counters_are_not_frozen) {
  constexpr int kSeeds = 60;
  const std::vector<std::function<double(double)>> speeds{
      [](double time) { return std::fmod(time, 6.0) < 4.0 ? 0.2 : 0.0; },
      [](double time) { return std::fmod(time, 6.0) < 4.0 ? 1.5 : 0.0; },
      [](double time) { return 0.5 + 0.5 * time; },
      [](double time) { return 5.0 - 0.4 * time; },
  };
  std::uint64_t exclusions = 0;
  for (const double tick : {0.02, 0.1})
    for (const double rate : {50.0, 3.0})
      for (std::size_t i = 0; i < speeds.size(); ++i)
        for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
          const OdometryConfiguration odometry = exactOdometry(tick);
          const Outcome outcome = run(odometry, straight(odometry, rate, 30.0, seed, speeds[i]));
          exclusions += outcome.sensors.exclusions;
          EXPECT_EQ(outcome.sensors.exclusions, 0u)
              << tick << " m, " << rate << " Hz, speed " << i << ", seed " << seed;
        }
  recordFigure("coarse counters: %.0f wheels taken for frozen", static_cast<double>(exclusions));
}

TEST_P(EachWheel, E7_is_taken_back_when_it_counts_again) {
  const OdometryConfiguration odometry = odometryOf(cycab(AxleGeometry::kAckermann, kTick));
  std::vector<Sample> drive = record(odometry.vehicle, driveOf(odometry, "slalom_eight", 1));
  scaleTravel(drive, GetParam(), 0.0, kFault, kFault + 10.0);
  const Outcome outcome = run(odometry, drive);
  EXPECT_TRUE(outcome.named[sensor(GetParam())]);
  EXPECT_TRUE(leftOut(outcome).empty());
  EXPECT_EQ(outcome.sensors.exclusions, 1u);
}

// --- E8: a wheel slips -----------------------------------------------------------------------------------

/// A fifth too far for two seconds.
TEST_P(EachWheel, E8_slip_is_named_and_the_covariance_bears_it) {
  constexpr std::size_t kDrives = 200;
  const OdometryConfiguration odometry = odometryOf(cycab(AxleGeometry::kAckermann, kTick));
  const std::size_t wheel = sensor(GetParam());
  std::vector<double> nees(kDrives);
  laboratory::runInParallel(kDrives, 0, [&](std::size_t i) {
    DriveSettings settings = driveOf(odometry, "slalom_eight", i);
    settings.duration = 30.0;  // (N1) holds as far as 0.1 rad (docs/model.md, 5.7)
    std::vector<Sample> drive = record(odometry.vehicle, settings);
    scaleTravel(drive, GetParam(), 1.2, kFault, kFault + 2.0);
    const Outcome outcome = run(odometry, drive);
    nees[i] = laboratory::exponentialNees(outcome.estimate, drive.back().truth);
    EXPECT_TRUE(outcome.named[wheel] && *outcome.named[wheel] - kFault <= kNamedWithin) << "seed " << i;
    EXPECT_TRUE(leftOut(outcome).empty()) << "taken back, seed " << i;
  });
  double mean = 0.0;
  for (const double value : nees) mean += value / kDrives;
  recordFigure("mean NEES %.2f of 3 dimensions over %zu drives", mean, kDrives);
  EXPECT_TRUE(laboratory::meanInterval(3.0, kDrives).holds(mean)) << mean;
}

// --- E9: wrong sign, swapped wheels ----------------------------------------------------------------------

TEST_P(EachWheel, E9_counter_that_runs_backwards_is_named) {
  for (const Vehicle& vehicle :
       {cycab(AxleGeometry::kAckermann, kTick), ordinaryCar(AxleGeometry::kAckermann)}) {
    const OdometryConfiguration odometry = odometryOf(vehicle);
    std::vector<Sample> drive = record(vehicle, driveOf(odometry, "slalom_eight", 2));
    scaleTravel(drive, GetParam(), -1.0);
    const Outcome outcome = run(odometry, drive);
    EXPECT_THAT(leftOut(outcome), ::testing::ElementsAre(sensor(GetParam())));
    EXPECT_EQ(outcome.sensors[GetParam()].fault, SensorFault::kReversed);
  }
}

INSTANTIATE_TEST_SUITE_P(Wheels, EachWheel, ::testing::ValuesIn(kAllWheels),
                         [](const auto& wheel) { return std::string(name(wheel.param)); });

TEST(Faults, E9_swapped_wheels_are_named) {
  int named = 0;
  for (const bool fixed_rear_axle : {true, false}) {
    Vehicle vehicle = cycab(AxleGeometry::kAckermann, kTick);
    if (fixed_rear_axle) vehicle.rear_steering.coefficients = {0.0};
    OdometryConfiguration odometry = odometryOf(vehicle);
    // Both wheels of a side differ by 8 % where this car turns most: the noise of a stretch must be less.
    odometry.noise.wheel = Distribution(0.002);
    for (std::size_t a = 0; a < kWheels; ++a)
      for (std::size_t b = a + 1; b < kWheels; ++b) {
        std::vector<Sample> drive = record(vehicle, driveOf(odometry, "slalom_eight", 3));
        swapCounters(drive, kAllWheels[a], kAllWheels[b]);
        const Outcome outcome = run(odometry, drive);
        SCOPED_TRACE(::testing::Message()
                     << "fixed rear axle " << fixed_rear_axle << ", wheels " << a << ", " << b);
        // Where the rear wheels steer against the front ones, both wheels of a side roll alike.
        if (!fixed_rear_axle && b == a + 2) {
          EXPECT_EQ(outcome.sensors.exclusions, 0u);
          continue;
        }
        EXPECT_THAT(leftOut(outcome), ::testing::ElementsAre(a, b));
        EXPECT_EQ(outcome.sensors.sensors[a].fault, SensorFault::kSwapped);
        EXPECT_EQ(outcome.sensors.sensors[b].fault, SensorFault::kSwapped);
        ++named;
      }
  }
  recordFigure("%d of 10 swaps that change anything named", named);
}

// --- E3: jumps -------------------------------------------------------------------------------------------

TEST(Faults, E3_one_percent_of_spikes_moves_the_end_by_less_than_one) {
  OdometryConfiguration odometry = odometryOf(cycab(AxleGeometry::kAckermann, kTick));
  double largest = 0.0;
  for (const double max_speed :
       {5.0, 40.0}) {  // a small jump is no jump for a fast car, and a fault all the same
    odometry.limits.max_speed = max_speed;
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      std::vector<Sample> drive = record(odometry.vehicle, driveOf(odometry, "slalom_eight", seed));
      const Outcome clean = run(odometry, drive);
      addSpikes(drive, 0.01, seed);
      OdometryPipeline pipeline(odometry);
      Pose2 end;
      for (const Sample& sample : drive) {
        const Time stamp = laboratory::stampOf(sample);
        pipeline.addSteering(Axle::kFront, stamp, stamp, sample.steering.front);
        pipeline.addWheels({stamp, stamp, sample.ticks});
        if (const auto update = pipeline.next(stamp)) end = update->estimate.pose;
      }
      const double moved = (end.position() - clean.estimate.pose.position()).norm() / clean.distance;
      EXPECT_LT(moved, 0.01) << max_speed << " m/s, seed " << seed;
      largest = std::max(largest, moved);
    }
  }
  recordFigure("1 %% of spikes move the end by %.2f %% of the distance at most", 100.0 * largest);
}

// --- steering --------------------------------------------------------------------------------------------

TEST(Faults, S6_sensor_that_lies_is_told_from_a_wheel) {
  const OdometryConfiguration odometry = odometryOf(cycab(AxleGeometry::kAckermann, kTick));
  const std::size_t steering = sensor(Axle::kFront);
  double latest = 0.0;
  for (const bool frozen : {true, false}) {
    std::vector<Sample> drive = record(odometry.vehicle, driveOf(odometry, "slalom_eight", 4));
    if (frozen) {
      freezeAngle(drive, Axle::kFront, kFault);
    } else {
      offsetAngle(drive, Axle::kFront, 0.1, kFault);
    }
    const Outcome outcome = run(odometry, drive);
    ASSERT_TRUE(outcome.named[steering]);
    EXPECT_LE(*outcome.named[steering] - kFault, kNamedWithin);
    EXPECT_THAT(leftOut(outcome), ::testing::ElementsAre(steering));
    EXPECT_LT(laboratory::exponentialNees(outcome.estimate, drive.back().truth), 16.3) << "0.1 %";
    latest = std::max(latest, *outcome.named[steering] - kFault);
  }
  recordFigure("an angle that freezes or jumps is named after %.2f s at the latest", latest);
}

/// Two sensors that err against each other: the fit weights them by what the wheels say.
TEST(Faults, S6_axles_that_disagree_are_weighted) {
  OdometryConfiguration odometry = odometryOf(cycabWithRearSensor(AxleGeometry::kAckermann));
  for (double& metres : odometry.vehicle.metres_per_tick.values) metres = kTick;
  DriveSettings settings = driveOf(odometry, "slalom_eight", 5);
  settings.noise.reset();
  settings.draw_gains.reset();
  double largest = 0.0;
  for (const double error : {0.01, -0.01}) {
    const std::vector<Sample> sound = record(odometry.vehicle, settings);
    std::vector<Sample> drive = sound;
    offsetAngle(drive, Axle::kFront, error);
    offsetAngle(drive, Axle::kRear, -error);
    std::size_t i = 0;
    laboratory::replay(odometry, drive, [&](const Sample&, const OdometryUpdate& update) {
      const Eigen::Vector3d& v = update.estimate.twist;
      if (i++ == 0) return;
      for (const Axle axle : kAllAxles) {
        const double angle = std::atan((v.y() + odometry.vehicle.axleX(axle) * v.z()) / v.x());
        const double truth = 0.5 * (sound[i - 2].steering[axle] + sound[i - 1].steering[axle]);
        ASSERT_NEAR(angle, truth, 0.01) << name(axle) << ", step " << i;
        largest = std::max(largest, std::abs(angle - truth));
      }
    });
  }
  recordFigure("10 mrad against each other: both angles within %.1f mrad", 1e3 * largest);
}

/// One sensor dies every 10 s.
std::vector<Sample> withThreeDead(std::vector<Sample> drive, const std::array<std::size_t, 3>& sensors) {
  double begin = 0.0;
  for (const std::size_t dead : sensors) {
    begin += 10.0;
    if (isWheel(dead)) {
      scaleTravel(drive, kAllWheels[dead], 0.0, begin);
    } else {
      freezeAngle(drive, Axle::kFront, begin);
    }
  }
  return drive;
}

/// The angle, then both wheels of the left side: what is left does not tell how the car turns.
TEST(Faults, E7_too_few_sensors_are_said_to_be_too_few) {
  const OdometryConfiguration odometry = odometryOf(cycab(AxleGeometry::kAckermann, kTick));
  const std::vector<Sample> drive =
      withThreeDead(record(odometry.vehicle, driveOf(odometry, "slalom_eight", 6)), {4, 0, 2});
  std::optional<double> said;
  laboratory::replay(odometry, drive, [&](const Sample& sample, const OdometryUpdate& update) {
    if (!update.report.sensors.determined && !said) said = sample.time;
  });
  const Outcome outcome = run(odometry, drive);
  EXPECT_FALSE(outcome.sensors.determined) << "still";
  EXPECT_LT(laboratory::exponentialNees(outcome.estimate, drive.back().truth), 16.3) << "0.1 %";
  ASSERT_TRUE(said);
  EXPECT_GT(*said, 30.0);
  EXPECT_LE(*said, 30.0 + kNamedWithin);
  recordFigure("three sensors of five dead: said after %.1f s", *said - 30.0);
}

/// Encoders and steering have been mended, as the diagnostics ask.
TEST(Faults, E7_reset_begins_anew_with_all_sensors) {
  const OdometryConfiguration odometry = odometryOf(cycab(AxleGeometry::kAckermann, kTick));
  const std::vector<Sample> sound = record(odometry.vehicle, driveOf(odometry, "slalom_eight", 6));
  const std::vector<Sample> drive = withThreeDead(sound, {4, 0, 2});
  const double mended = 35.0;
  OdometryPipeline pipeline(odometry);
  bool determined_before = true;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    if (sound[i].time < mended) {
      determined_before = laboratory::step(pipeline, drive[i]).report.sensors.determined;
      continue;
    }
    if (sound[i - 1].time < mended) pipeline.reset();
    const SensorReport report = laboratory::step(pipeline, sound[i]).report.sensors;
    ASSERT_TRUE(report.determined) << sound[i].time << " s";
    for (const SensorState& sensor : report.sensors) ASSERT_EQ(sensor.fault, SensorFault::kNone);
  }
  EXPECT_FALSE(determined_before);
}

/// All orders in which three sensors of five can die, one every 10 s. Not all of that can be known: when the
/// wheels of one side are gone, nothing tells that the angle freezes, as those of the other side turn alike.
TEST(Faults, E7_three_dead_sensors_are_in_the_covariance) {
  const OdometryConfiguration odometry = odometryOf(cycab(AxleGeometry::kAckermann, kTick));
  const std::vector<Sample> sound = record(odometry.vehicle, driveOf(odometry, "slalom_eight", 6));
  std::array<std::size_t, 5> order{0, 1, 2, 3, 4};
  std::size_t orders = 0;
  std::size_t inside = 0;
  do {
    if (order[3] > order[4]) continue;  // they stay alive
    const std::vector<Sample> drive = withThreeDead(sound, {order[0], order[1], order[2]});
    const double nees = laboratory::exponentialNees(run(odometry, drive).estimate, drive.back().truth);
    ++orders;
    if (nees < 16.3) ++inside;  // 0.1 %
  } while (std::next_permutation(order.begin(), order.end()));
  recordFigure("three of five dead, in %zu orders: the truth within 0.1 %% in %zu", orders, inside);
  EXPECT_EQ(orders, 60u);
  EXPECT_GE(inside, 45u) << "12 orders take one side's wheels and the angle";
}

// --- dead from the start ---------------------------------------------------------------------------------

/// The sensors of a car with an angle on each axle; the counter or angle of one never moves.
class DeadFromTheStart : public ::testing::TestWithParam<std::size_t> {};

TEST_P(DeadFromTheStart, E7_drift_is_what_the_covariance_predicts) {
  constexpr std::size_t kDrives = 200;
  OdometryConfiguration odometry = odometryOf(cycabWithRearSensor(AxleGeometry::kAckermann));
  for (double& metres : odometry.vehicle.metres_per_tick.values) metres = kTick;
  std::vector<double> error(kDrives);
  std::vector<double> predicted(kDrives);
  std::vector<double> nees(kDrives);
  std::vector<int> named_alone(kDrives);
  laboratory::runInParallel(kDrives, 0, [&](std::size_t i) {
    DriveSettings settings = driveOf(odometry, "slalom_eight", i);
    settings.duration = 30.0;
    std::vector<Sample> drive = record(odometry.vehicle, settings);
    if (isWheel(GetParam())) {
      scaleTravel(drive, kAllWheels[GetParam()], 0.0);
    } else {
      freezeAngle(drive, kAllAxles[GetParam() - kWheels]);
    }
    const Outcome outcome = run(odometry, drive);
    error[i] = positionError(outcome, drive);
    predicted[i] = std::sqrt(outcome.estimate.pose_covariance.topLeftCorner<2, 2>().trace());
    nees[i] = laboratory::exponentialNees(outcome.estimate, drive.back().truth);
    named_alone[i] = leftOut(outcome) == std::vector<std::size_t>{GetParam()} ? 1 : 0;
  });
  const auto inside = [](double square) { return square < laboratory::sigmaRegions(3.0)[2]; };
  const auto within = std::count_if(nees.begin(), nees.end(), inside);
  recordFigure("dead from the start: drift %.2f times the predicted, %td of %zu inside 3 sigma",
               rootMeanSquare(error) / rootMeanSquare(predicted), within, kDrives);
  EXPECT_LE(rootMeanSquare(error), 1.2 * rootMeanSquare(predicted));
  // 99.7 %: fewer than 196 of 200 would come once in 300 times.
  EXPECT_GE(within, 196);
  // A drive in which a second one is left out as well must be an exception.
  EXPECT_GE(std::count(named_alone.begin(), named_alone.end(), 1), 198);
}

INSTANTIATE_TEST_SUITE_P(Sensors, DeadFromTheStart, ::testing::Range<std::size_t>(0, kSensors));

// --- nothing is wrong ------------------------------------------------------------------------------------

/// 24 hours at 10 Hz, in 144 drives with gains from p(A) that nobody has calibrated.
TEST(Faults, E7_24_hours_without_a_false_alarm) {
  constexpr std::size_t kDrives = 144;
  const OdometryConfiguration odometry = odometryOf(cycab(AxleGeometry::kAckermann, kTick));
  const std::array<const char*, 4> scenarios{"slalom_eight", "fig4", "square_loop", "circle"};
  std::array<std::uint64_t, kDrives> exclusions{};
  std::array<double, kDrives> seconds{};
  laboratory::runInParallel(kDrives, 0, [&](std::size_t i) {
    DriveSettings settings =
        driveOf(odometry, scenarios[i % scenarios.size()], 1000 + i, 0.5 + 0.5 * static_cast<double>(i % 5));
    settings.rate = 10.0;
    settings.substep = 0.05;
    settings.duration = 600.0;
    const std::vector<Sample> drive = record(odometry.vehicle, settings);
    exclusions[i] = run(odometry, drive).sensors.exclusions;
    seconds[i] = drive.back().time;
  });
  double total = 0.0;
  for (std::size_t i = 0; i < kDrives; ++i) {
    EXPECT_EQ(exclusions[i], 0u) << scenarios[i % scenarios.size()] << ", seed " << kFirstSeed + 1000 + i;
    total += seconds[i];
  }
  EXPECT_NEAR(total, 24 * 3600.0, 1.0);
  recordFigure("%llu false alarms in %.0f hours",
               static_cast<unsigned long long>(
                   std::accumulate(exclusions.begin(), exclusions.end(), std::uint64_t{0})),
               total / 3600.0);
}

}  // namespace
}  // namespace bs_car_odometry::drives
