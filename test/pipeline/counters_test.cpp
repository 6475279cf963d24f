// Encoders: wraps, restarts, spikes, losses (docs/reliability.md, E rows).

#include "bench.hpp"
#include "support/figure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

namespace bs_car_odometry::bench {
namespace {

using Ticks = PerWheel<std::int64_t>;

constexpr double kPeriod = 0.02;             // s
constexpr Ticks kPerStep{{50, 53, 49, 52}};  // ticks, of a gentle turn
constexpr std::int64_t kLargestStep = 53;

Ticks after(std::int64_t start, int steps, int direction) {
  Ticks ticks;
  for (const Wheel wheel : kAllWheels) ticks[wheel] = start + direction * steps * kPerStep[wheel];
  return ticks;
}

Ticks wrapped(Ticks ticks, int bits, bool is_signed) {
  const std::int64_t range = std::int64_t{1} << bits;
  for (std::int64_t& count : ticks.values) {
    count = ((count % range) + range) % range;
    if (is_signed && count >= range / 2) count -= range;
  }
  return ticks;
}

/// bits, signed, direction
class Wrapping : public ::testing::TestWithParam<std::tuple<int, bool, int>> {};

TEST_P(Wrapping, E1_counter_wraps) {
  const auto [bits, is_signed, direction] = GetParam();
  const std::int64_t end = std::int64_t{1} << (is_signed ? bits - 1 : bits);
  OdometryConfiguration wrapping = cycab();
  wrapping.vehicle.counter_bits = bits;
  OdometryConfiguration unlimited = cycab();
  unlimited.vehicle.counter_bits = 0;
  constexpr int kSteps = 8;
  // Every phase of the step that crosses the end.
  for (std::int64_t start = end - direction * 4 * kLargestStep; start < end + kLargestStep; ++start) {
    Bench a(wrapping);
    Bench b(unlimited);
    for (int i = 0; i <= kSteps; ++i) {
      const Ticks ticks = after(start, i, direction);
      const auto with_wrap = a.step(i * kPeriod, wrapped(ticks, bits, is_signed), 0.1);
      const auto without = b.step(i * kPeriod, ticks, 0.1);
      ASSERT_TRUE(with_wrap && without);
      ASSERT_TRUE(identical(with_wrap->estimate, without->estimate)) << "start " << start << ", step " << i;
    }
    ASSERT_GT(b.pipeline.counts().wheel_messages, 0u);
  }
  recordFigure("identical in every bit");
}

INSTANTIATE_TEST_SUITE_P(Widths, Wrapping,
                         ::testing::Combine(::testing::Values(8, 16, 24, 32), ::testing::Bool(),
                                            ::testing::Values(1, -1)));

TEST(Counters, E2_restart) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> count(20000, 2000000000);
  double largest = 0.0;
  for (int trial = 0; trial < 20; ++trial) {
    Bench bench;
    const std::int64_t start = count(random);
    SCOPED_TRACE(start);
    constexpr int kBefore = 5;
    std::optional<OdometryUpdate> last;
    for (int i = 0; i <= kBefore; ++i) last = bench.step(i * kPeriod, after(start, i, 1));
    ASSERT_TRUE(last);

    EXPECT_FALSE(bench.step((kBefore + 1) * kPeriod, all(0))) << "one jump may be a spike";
    EXPECT_EQ(bench.pipeline.counts()[Verdict::kImplausible], 1u);
    const auto first = bench.step((kBefore + 2) * kPeriod, after(0, 1, 1));
    ASSERT_TRUE(first) << "two that follow each other are a restart";
    EXPECT_EQ(first->report.counts.counter_restarts, 1u);
    const Eigen::Vector2d moved = first->estimate.pose.position() - last->estimate.pose.position();
    EXPECT_LT(moved.norm(), 1.01e-4 * kLargestStep) << "the pose is kept";
    largest = std::max(largest, moved.norm());
    // Unseen: one period at 5 m/s.
    const Eigen::Matrix3d growth = first->estimate.pose_covariance - last->estimate.pose_covariance;
    EXPECT_GT(growth(0, 0), 0.99 * std::pow(5.0 * kPeriod, 2));
    EXPECT_GT(growth(1, 1), 0.99 * std::pow(5.0 * kPeriod, 2));
    EXPECT_GT(growth(2, 2), 0.99 * std::pow(5.0 * kPeriod / 1.2, 2));

    const auto second = bench.step((kBefore + 3) * kPeriod, after(0, 2, 1));
    ASSERT_TRUE(second);
    EXPECT_EQ(second->report.counts.counter_restarts, 1u) << "one event each";
    EXPECT_NEAR(second->report.step, first->report.step, 1e-9);
  }
  recordFigure("the pose moves by %.1f mm, the step that was counted", 1e3 * largest);
}

/// Three steps do without the wheel: those that end in the spike, begin with it, and begin with the jump
/// back.
TEST(Counters, E3_spike_leaves_out_its_wheel) {
  Bench spiked;
  Bench clean;
  for (int i = 0; i <= 10; ++i) {
    Ticks ticks = after(100, i, 1);
    const auto b = clean.step(i * kPeriod, ticks);
    if (i == 5) ticks[Wheel::kRearLeft] += 1000000;
    const auto a = spiked.step(i * kPeriod, ticks);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->report.wheel_used[Wheel::kRearLeft], i > 0 && (i < 5 || i > 7)) << i;
    if (i < 5) {
      EXPECT_TRUE(identical(a->estimate, b->estimate));
    } else {
      // The wheels of the bench differ by 8 % of a step of 5 mm.
      const Eigen::Vector3d difference = a->estimate.pose.vector() - b->estimate.pose.vector();
      EXPECT_LT(difference.head<2>().norm(), 3 * 0.08 * 0.005);
      EXPECT_GT(difference.head<2>().norm(), 0.0);
    }
  }
  EXPECT_EQ(spiked.pipeline.counts().wheel_jumps, 2u) << "there and back";
  EXPECT_EQ(spiked.pipeline.counts()[Verdict::kImplausible], 0u);
  EXPECT_EQ(spiked.pipeline.counts().counter_restarts, 0u);
}

/// With one axle there is nothing to do without.
TEST(Counters, E3_spike_of_a_needed_wheel_leaves_out_the_message) {
  OdometryConfiguration configuration = cycab();
  configuration.options.axles = AxleSelection::kRear;
  Bench spiked(configuration);
  Bench clean(configuration);
  for (int i = 0; i <= 10; ++i) {
    const bool spike = i == 5;
    Ticks ticks = after(100, i, 1);
    if (spike) {
      ticks[Wheel::kRearLeft] += 1000000;
    } else {
      ASSERT_TRUE(clean.step(i * kPeriod, ticks));
    }
    EXPECT_EQ(spiked.step(i * kPeriod, ticks).has_value(), !spike);
  }
  const auto a = spiked.step(1.0, after(100, 11, 1));
  const auto b = clean.step(1.0, after(100, 11, 1));
  ASSERT_TRUE(a && b);
  EXPECT_TRUE(identical(a->estimate, b->estimate));
  EXPECT_EQ(a->report.counts[Verdict::kImplausible], 1u);
  EXPECT_EQ(a->report.counts.counter_restarts, 0u);
}

TEST(Counters, E4_any_first_value_gives_the_initial_pose) {
  std::mt19937_64 random(4);
  std::uniform_int_distribution<std::int64_t> any(-(std::int64_t{1} << 31), (std::int64_t{1} << 32) - 1);
  std::vector<std::int64_t> starts{0, 1, -1, 2147483647, 2147483648, -2147483648, 4294967295};
  for (int i = 0; i < 1000; ++i) starts.push_back(any(random));
  const InitialPose initial = cycab().initial_pose;
  for (const std::int64_t start : starts) {
    Bench bench;
    const auto first = bench.step(0.0, after(start, 7, 1));
    ASSERT_TRUE(first);
    ASSERT_EQ(first->estimate.pose.x, initial.x) << start;
    ASSERT_EQ(first->estimate.pose.y, initial.y) << start;
    ASSERT_EQ(first->estimate.pose.yaw, initial.yaw) << start;
    ASSERT_TRUE(first->estimate.pose_covariance == initial.covariance) << start;
    ASSERT_EQ(first->report.distance, 0.0) << start;
  }
  recordFigure("exactly the initial pose after each of %zu first values", starts.size());
}

TEST(Counters, E5_lost_messages) {
  constexpr double kDuration = 100.0;
  const OdometryConfiguration configuration = cycab();
  const Drive drive = slalom(configuration, kDuration, 50.0, 50.0);
  double largest = 0.0;
  double turned = 0.0;
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::bernoulli_distribution lost(0.3);
    std::vector<Message> messages;
    for (const Message& message : drive.messages)
      if (message.stamp == 0.0 || message.stamp >= kDuration - 1e-9 || !lost(random))
        messages.push_back(message);
    ASSERT_LT(4 * messages.size(), 3 * drive.messages.size());

    const std::vector<OdometryUpdate> updates = run(configuration, messages);
    ASSERT_FALSE(updates.empty());
    EXPECT_LT(largestDeparture(updates, drive), 1e-3);
    EXPECT_NEAR(updates.back().report.distance, drive.length, 1e-3 * drive.length);
    const double heading_error =
        wrapAngle(updates.back().estimate.pose.yaw - drive.truth.back().pose.yaw) * 180.0 / M_PI;
    EXPECT_LT(std::abs(heading_error), 0.2 * drive.length / 100.0);
    largest = std::max(largest, largestDeparture(updates, drive));
    turned = std::max(turned, std::abs(heading_error) * 100.0 / drive.length);
  }
  recordFigure("30 %% lost: off by %.3f %% of the distance and %.3f degrees in 100 m", 100.0 * largest,
               turned);
}

}  // namespace
}  // namespace bs_car_odometry::bench
