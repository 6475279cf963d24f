// The state: refused when not finite, unchanged while parked (docs/reliability.md, O rows).

#include "bench.hpp"
#include "support/figure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <random>

namespace bs_car_odometry::bench {
namespace {

constexpr double kPeriod = 0.02;  // s

TEST(State, O1_non_finite_state_is_not_committed) {
  for (const double fault : {std::nan(""), std::numeric_limits<double>::signaling_NaN()}) {
    OdometryConfiguration configuration = cycab();
    configuration.vehicle.gains.rear.k_l = fault;
    Bench bench(configuration);
    const auto first = bench.step(0.0, all(0));
    ASSERT_TRUE(first);
    for (int i = 1; i <= 5; ++i) {
      const auto update = bench.step(i * kPeriod, all(100 * i), 0.1);
      ASSERT_TRUE(update);
      EXPECT_TRUE(isFinite(*update));
      EXPECT_EQ(update->estimate.pose.vector(), first->estimate.pose.vector()) << "the last good state";
      EXPECT_EQ(update->report.counts.refused_states, static_cast<std::uint64_t>(i));
      EXPECT_EQ(update->report.state, OdometryState::kDegraded);
      EXPECT_EQ(update->estimate.twist, Eigen::Vector3d::Zero());
      EXPECT_GT(update->estimate.pose_covariance(0, 0), 0.99 * i * std::pow(5.0 * kPeriod, 2)) << "inflated";
    }
  }
}

/// Four wheels and two angles that are each plausible, and contradict each other in every way.
TEST(State, O1_no_step_is_longer_than_max_speed_allows) {
  constexpr unsigned kSeed = 7;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  OdometryConfiguration configuration = cycab();
  configuration.vehicle.rear_steering.source = RearSteering::Source::kMeasured;
  const double longest = configuration.limits.max_speed * (1.5 * kPeriod + 0.01);
  std::uniform_int_distribution<std::int64_t> travel(-1999, 1999);  // ticks of 0.1 mm, up to the longest step
  std::uniform_real_distribution<double> angle(-1.3, 1.3);
  Bench bench(configuration);
  PerWheel<std::int64_t> ticks;
  Pose2 before;
  double largest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    for (const Axle axle : kAllAxles)
      bench.pipeline.addSteering(axle, at(i * kPeriod), at(i * kPeriod), angle(random));
    for (std::int64_t& count : ticks.values) count += travel(random);
    bench.wheels(i * kPeriod, ticks);
    const auto update = bench.next(i * kPeriod);
    ASSERT_TRUE(update);
    const Pose2& pose = update->estimate.pose;
    if (i > 0) {
      ASSERT_LE(std::hypot(pose.x - before.x, pose.y - before.y), longest + 1e-12) << "step " << i;
      largest = std::max(largest, std::hypot(pose.x - before.x, pose.y - before.y));
    }
    before = pose;
  }
  EXPECT_GT(bench.pipeline.counts().refused_states, 0u) << "there were some";
  EXPECT_LT(bench.pipeline.counts().refused_states, 1000u) << "most are taken";
  recordFigure("contradicting sensors: steps up to %.3f m of %.3f m allowed", largest, longest);
}

TEST(State, O1_infinite_travel_is_never_taken) {
  OdometryConfiguration configuration = cycab();
  configuration.vehicle.counter_bits = 0;
  for (const Wheel wheel : kAllWheels) configuration.vehicle.metres_per_tick[wheel] = 1e308;
  Bench bench(configuration);
  const auto first = bench.step(0.0, all(0));
  for (int i = 1; i <= 5; ++i)
    if (const auto update = bench.step(i * kPeriod, all(100 * i))) {
      EXPECT_TRUE(isFinite(*update));
      EXPECT_EQ(update->estimate.pose.vector(), first->estimate.pose.vector());
    }
  EXPECT_GT(bench.pipeline.counts()[Verdict::kImplausible], 0u);
}

TEST(State, O1_infinite_travel_of_one_wheel_is_left_out) {
  OdometryConfiguration configuration = cycab();
  configuration.vehicle.metres_per_tick[Wheel::kFrontLeft] = 1e308;
  configuration.vehicle.counter_bits = 0;
  Bench bench(configuration);
  bench.step(0.0, all(0));
  for (int i = 1; i <= 5; ++i) {
    const auto update = bench.step(i * kPeriod, all(100 * i));
    ASSERT_TRUE(update && isFinite(*update));
    EXPECT_NEAR(update->report.distance, 0.01 * i, 1e-9) << "by the other wheels";
  }
  EXPECT_EQ(bench.pipeline.counts().wheel_jumps, 5u);
}

TEST(State, O1_goes_on_when_the_fault_is_over) {
  Bench bench;
  bench.step(0.0, all(0));
  // 3 m on, a heading of this variance would make the position's infinite.
  const double huge = 0.25 * std::numeric_limits<double>::max();
  bench.pipeline.setPose({}, Eigen::Vector3d(huge, huge, huge).asDiagonal());
  const auto uncertain = bench.step(1.0, all(30000));
  ASSERT_TRUE(uncertain && isFinite(*uncertain));
  EXPECT_GT(uncertain->estimate.pose_covariance(0, 0), 1e29);
  bench.pipeline.setPose({}, Eigen::Matrix3d::Identity());
  const auto good = bench.step(1.0 + kPeriod, all(30100));
  ASSERT_TRUE(good);
  EXPECT_EQ(good->report.state, OdometryState::kNominal);
  EXPECT_NEAR(good->report.step, 0.01, 1e-12);
}

TEST(State, O1_hostile_counters) {
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
  for (const int bits : {0, 8, 32}) {
    OdometryConfiguration configuration = cycab();
    configuration.vehicle.counter_bits = bits;
    Bench bench(configuration);
    std::mt19937_64 random(7);
    for (int i = 0; i < 10000; ++i) {
      PerWheel<std::int64_t> ticks;
      for (std::int64_t& count : ticks.values) count = i % 3 == 0 ? static_cast<std::int64_t>(random()) : 0;
      if (i % 7 == 0) ticks = all(kMax);
      if (i % 7 == 1) ticks = all(kMin);
      const auto update = bench.step(i * kPeriod, ticks);
      ASSERT_TRUE(!update || isFinite(*update)) << i;
    }
  }
}

/// 24 h at 100 Hz, the steering trembling.
TEST(State, O3_parked_is_bitwise_unchanged) {
  Bench bench;
  for (int i = 0; i <= 100; ++i) bench.step(0.01 * i - 2.0, {{0, 1, 2 * i, i * i}}, 0.1);
  bench.step(0.0, all(10000), 0.1);  // after a gap, whose doubt settles with the step that follows
  const auto before = bench.step(0.01, all(10000), 0.1);
  ASSERT_TRUE(before);
  auto last = before;
  constexpr int kSteps = 24 * 3600 * 100;
  for (int i = 2; i <= kSteps; ++i) {
    last = bench.step(0.01 * i, all(10000), 0.1 + 1e-3 * (i % 5));
    ASSERT_TRUE(last && last->estimate.pose_covariance == before->estimate.pose_covariance) << i;
  }
  OdometryEstimate parked = before->estimate;
  parked.twist = last->estimate.twist;
  parked.twist_covariance = last->estimate.twist_covariance;
  EXPECT_TRUE(identical(parked, last->estimate));
  EXPECT_EQ(last->estimate.twist.norm(), 0.0);
  EXPECT_EQ(last->report.distance, before->report.distance);
  recordFigure("24 hours parked at 100 Hz, identical in every bit");
}

}  // namespace
}  // namespace bs_car_odometry::bench
