// Steering: hostile values, and its way to the wheels' time (docs/reliability.md, S rows).

#include "bench.hpp"
#include "support/figure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace bs_car_odometry::bench {
namespace {

constexpr double kPeriod = 0.05;  // s
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Steering, S1_hostile_values_change_nothing) {
  Bench clean;
  Bench hostile;
  for (int i = 0; i <= 20; ++i) {
    for (const double angle :
         {std::nan(""), kInfinity, -kInfinity, std::numeric_limits<double>::signaling_NaN()})
      EXPECT_EQ(hostile.steer(i * kPeriod - 0.01, angle), Verdict::kNotFinite);
    const auto a = clean.step(i * kPeriod, all(100 * i), 0.02 * i);
    const auto b = hostile.step(i * kPeriod, all(100 * i), 0.02 * i);
    ASSERT_TRUE(a && b && isFinite(*b));
    EXPECT_TRUE(identical(a->estimate, b->estimate));
  }
  EXPECT_EQ(hostile.pipeline.counts()[Verdict::kNotFinite], 4u * 21u);
  recordFigure("identical in every bit");
}

TEST(Steering, S1_largest_numbers_are_beyond_the_limit) {
  for (const double angle : {1e308, -1e308, std::numeric_limits<double>::max()})
    EXPECT_EQ(Bench().steer(0.0, angle), Verdict::kSteeringLimit);
  OdometryConfiguration scaled = cycab();
  scaled.vehicle.steering.front.scale = 1000.0;
  EXPECT_EQ(Bench(scaled).steer(0.0, 1e308), Verdict::kSteeringLimit) << "infinite after the scale";
  EXPECT_EQ(Bench().steer(0.0, 5e-324), Verdict::kAccepted);
}

TEST(Steering, S2_S3_beyond_limit) {
  double largest = 0.0;
  for (double angle = 0.0; angle < M_PI / 2; angle += 0.01) {
    Bench bench;
    const bool within = angle <= 1.3;
    ASSERT_EQ(bench.steer(0.0, angle), within ? Verdict::kAccepted : Verdict::kSteeringLimit) << angle;
    if (!within) continue;
    bench.wheels(0.0, all(0));
    ASSERT_TRUE(bench.next(0.0));
    const auto update = bench.step(kPeriod, all(1000), angle);
    ASSERT_TRUE(update && isFinite(*update));
    const double turn = update->estimate.pose.yaw - cycab().initial_pose.yaw;
    EXPECT_LT(std::abs(turn), 0.3) << "after 0.1 m on every wheel, at " << angle;
    largest = std::max(largest, std::abs(turn));
  }
  recordFigure("0.1 m on every wheel turn by %.2f rad at most", largest);
  EXPECT_EQ(Bench().steer(0.0, 20.0), Verdict::kSteeringLimit) << "degrees";
}

TEST(Steering, S3_limit_is_that_of_the_angle_and_not_of_the_reading) {
  OdometryConfiguration configuration = cycab();
  configuration.vehicle.steering.front = {M_PI / 180.0, 0.1};
  Bench bench(configuration);
  EXPECT_EQ(bench.steer(0.0, 30.0), Verdict::kAccepted);
  EXPECT_EQ(bench.steer(0.1, 75.0), Verdict::kSteeringLimit);
  bench.wheels(0.0, all(0));
  EXPECT_NEAR(bench.next(0.0)->report.steering_angle.front, M_PI / 6 + 0.1, 1e-12);
}

/// The drive without what was sampled in between.
Drive without(Drive drive, double from, double to, bool wheels) {
  const auto lost = [&](const Message& message) {
    return message.isWheels() == wheels && message.stamp > from && message.stamp < to;
  };
  drive.messages.erase(std::remove_if(drive.messages.begin(), drive.messages.end(), lost),
                       drive.messages.end());
  return drive;
}

/// Largest error in x, y and yaw over its standard deviation, where the odometry is at least a second under
/// way.
double largestSigmas(const std::vector<OdometryUpdate>& updates, const Drive& drive) {
  double largest = 0.0;
  for (const OdometryUpdate& update : updates) {
    for (const Truth& truth : drive.truth) {
      if (at(truth.stamp) != update.stamp || truth.stamp < 1.0) continue;
      const Pose2& pose = update.estimate.pose;
      const Eigen::Vector3d error(pose.x - truth.pose.x, pose.y - truth.pose.y, pose.yaw - truth.pose.yaw);
      const Eigen::Vector3d sigma = update.estimate.pose_covariance.diagonal().cwiseSqrt();
      largest = std::max(largest, error.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
    }
  }
  return largest;
}

// The angle swings from one side to the other while nothing is heard of it; the systematic noise, which would
// hide the error, is off.
/// With one axle the car goes where its steering says; with both, the wheels say how it turns when the angle
/// is too old, not quite as well as the angle did.
TEST(Steering, S4_stale_angle_is_held_and_the_covariance_says_so) {
  OdometryConfiguration configuration = cycab();
  configuration.noise.systematic = {0.0, 0.0, 0.0, 0.0};
  double largest = 0.0;
  for (const AxleSelection axles : {AxleSelection::kRear, AxleSelection::kBoth}) {
    configuration.options.axles = axles;
    const double larger = axles == AxleSelection::kRear ? 2.0 : 1.02;
    SCOPED_TRACE(larger);
    const Drive drive = slalom(configuration, 20.0, 50.0, 50.0);
    const std::vector<OdometryUpdate> heard = run(configuration, drive.messages);
    const std::vector<OdometryUpdate> updates = run(configuration, without(drive, 6.0, 12.0, false).messages);
    ASSERT_EQ(updates.size(), heard.size());
    EXPECT_LT(largestSigmas(updates, drive), 3.0);
    largest = std::max(largest, largestSigmas(updates, drive));
    for (std::size_t i = 0; i < updates.size(); ++i) {
      const double seconds = toSeconds(updates[i].stamp - at(0.0));
      const bool stale = updates[i].report.state == OdometryState::kNoSteering;
      EXPECT_EQ(stale, seconds > 6.2 + 1e-9 && seconds < 12.0) << seconds;
      // With one axle the direction suffers, with both the turn.
      const auto variance = [&](const Eigen::Matrix3d& covariance) {
        return axles == AxleSelection::kRear ? covariance.trace() : covariance(2, 2);
      };
      const auto& estimate = updates[i].estimate;
      const auto& with_steering = heard[i].estimate;
      if (seconds > 7.2) {
        EXPECT_GT(variance(estimate.pose_covariance), larger * variance(with_steering.pose_covariance));
      }
      if (stale && seconds > 6.25) {  // the doubt grows from nothing
        EXPECT_GT(variance(estimate.twist_covariance), larger * variance(with_steering.twist_covariance));
      }
    }
  }
  recordFigure("6 s without an angle in mid-turn: truth inside %.1f sigma", largest);
}

TEST(Steering, E6_unknown_steering_inside_a_gap_inflates) {
  OdometryConfiguration configuration = cycab();
  configuration.noise.systematic = {0.0, 0.0, 0.0, 0.0};
  double largest = 0.0;
  for (const double gap : {0.1, 1.0, 10.0, 100.0}) {
    const Drive drive = slalom(configuration, gap + 10.0, 50.0, 50.0);
    const std::vector<OdometryUpdate> updates =
        run(configuration, without(drive, 5.0, 5.0 + gap, true).messages);
    EXPECT_LT(largestSigmas(updates, drive), 3.0) << gap << " s";
    largest = std::max(largest, largestSigmas(updates, drive));
    EXPECT_EQ(updates.back().report.counts.gaps, gap > 0.5 ? 1u : 0u);
    EXPECT_EQ(updates.back().report.counts.ambiguous_gaps, 0u) << "32 bits are half a million kilometres";
  }
  recordFigure("gaps of 0.1 to 100 s: truth inside %.1f sigma", largest);
}

// 16 bits of 0.1 mm wrap after 6.6 m: in 10 s at up to 5 m/s nobody knows how often.
TEST(Steering, E6_counters_that_may_have_wrapped_unseen_are_taken_anew) {
  OdometryConfiguration configuration = cycab();
  configuration.noise.systematic = {0.0, 0.0, 0.0, 0.0};
  configuration.vehicle.counter_bits = 16;
  double largest = 0.0;
  for (const double gap : {0.1, 0.6, 1.0, 10.0, 100.0}) {
    SCOPED_TRACE(gap);
    const Drive drive = slalom(configuration, gap + 10.0, 50.0, 50.0);
    const std::vector<OdometryUpdate> updates =
        run(configuration, without(drive, 5.0, 5.0 + gap, true).messages);
    EXPECT_LT(largestSigmas(updates, drive), 3.0);
    largest = std::max(largest, largestSigmas(updates, drive));
    // Half of the range is 3.2768 m, which 5 m/s takes 0.655 s for.
    const bool ambiguous = gap > 0.655;
    EXPECT_EQ(updates.back().report.counts.ambiguous_gaps, ambiguous ? 1u : 0u);
    if (!ambiguous) continue;
    const auto after = std::find_if(updates.begin(), updates.end(), [](const OdometryUpdate& update) {
      return update.report.counts.ambiguous_gaps == 1;
    });
    ASSERT_NE(after, updates.begin());
    EXPECT_EQ(after->estimate.pose.vector(), std::prev(after)->estimate.pose.vector()) << "the pose is kept";
    EXPECT_EQ(after->estimate.twist_covariance(0, 0), 25.0) << "the twist is not known";
    EXPECT_GT(after->estimate.pose_covariance(0, 0), 0.99 * std::pow(5.0 * gap, 2)) << "inflated";
    ASSERT_NE(std::next(after), updates.end());
    EXPECT_GT(std::next(after)->report.step, 0.0) << "it goes on from there";
  }
  recordFigure("16 bits, gaps of 0.1 to 100 s: truth inside %.1f sigma", largest);
}

TEST(Steering, S4_never_seen_gives_no_odometry) {
  Bench bench;
  for (int i = 0; i < 10; ++i) {
    bench.wheels(i * kPeriod, all(i));
    EXPECT_FALSE(bench.next(i * kPeriod + 0.03));
  }
  EXPECT_EQ(bench.pipeline.counts()[Verdict::kNoSteering], 10u);
  EXPECT_FALSE(bench.pipeline.started());
}

TEST(Steering, S5_late_by_5_ms_is_waited_for) {
  Bench bench;
  bench.step(0.0, all(0), 0.1);
  bench.wheels(kPeriod, all(100), kPeriod + 0.001);
  EXPECT_EQ(bench.pipeline.deadline(), at(kPeriod + 0.021));
  EXPECT_FALSE(bench.next(kPeriod + 0.001));
  EXPECT_FALSE(bench.next(kPeriod + 0.005));
  bench.steer(kPeriod, 0.2, kPeriod + 0.006);
  const auto update = bench.next(kPeriod + 0.006);
  ASSERT_TRUE(update);
  EXPECT_EQ(update->completed, at(kPeriod + 0.006));
  EXPECT_EQ(update->stamp, at(kPeriod));
  EXPECT_DOUBLE_EQ(update->report.steering_angle.front, 0.15) << "mean of both ends";
  EXPECT_EQ(update->report.counts.steering_held, 0u);
  EXPECT_FALSE(bench.pipeline.deadline());
}

TEST(Steering, S5_late_by_50_ms_is_held_and_serves_the_next_step) {
  Bench bench;
  bench.step(0.0, all(0), 0.1);
  bench.wheels(kPeriod, all(100));
  EXPECT_FALSE(bench.next(kPeriod + 0.0199));
  const auto held = bench.next(kPeriod + 0.02);
  ASSERT_TRUE(held);
  EXPECT_EQ(held->completed, at(kPeriod + 0.02));
  EXPECT_DOUBLE_EQ(held->report.steering_angle.front, 0.1);
  EXPECT_EQ(held->report.counts.steering_held, 1u);
  EXPECT_NEAR(held->report.steering_age.front, kPeriod, 1e-9);

  bench.steer(kPeriod, 0.3, kPeriod + 0.05);
  const auto after = bench.step(2 * kPeriod, all(200), 0.5);
  ASSERT_TRUE(after);
  EXPECT_DOUBLE_EQ(after->report.steering_angle.front, 0.4) << "the late reading is this step's beginning";
  EXPECT_EQ(after->report.counts.steering_held, 1u);
}

/// A caller that looks too late gets the time at which the wait was over, not its own.
TEST(Steering, S5_completed_is_the_end_of_the_wait) {
  Bench bench;
  bench.step(0.0, all(0), 0.1);
  bench.wheels(kPeriod, all(100));
  bench.wheels(kPeriod + 0.01, all(120));
  const auto first = bench.next(9.0);
  const auto second = bench.next(9.0);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->completed, at(kPeriod + 0.02));
  EXPECT_EQ(second->completed, at(kPeriod + 0.03));
}

TEST(Steering, S5_waits_then_holds_when_it_stops) {
  Bench bench;
  bench.step(0.0, all(0), 0.1);
  for (int i = 1; i <= 10; ++i) {
    bench.wheels(i * kPeriod, all(100 * i));
    const auto update = bench.next(i * kPeriod + 0.02);
    ASSERT_TRUE(update);
    EXPECT_DOUBLE_EQ(update->report.steering_angle.front, 0.1);
    EXPECT_EQ(update->report.counts.steering_held, static_cast<std::uint64_t>(i));
    const bool stale = i * kPeriod > 0.2;
    EXPECT_EQ(update->report.state, stale ? OdometryState::kNoSteering : OdometryState::kNominal) << i;
  }
}

TEST(Steering, S5_rates_far_apart_give_the_same_path) {
  const OdometryConfiguration configuration = cycab();
  double largest = 0.0;
  // 1 kHz and 25 Hz, 10 Hz and 400 Hz.
  for (const auto& [wheel_rate, steering_rate] : {std::pair(1000.0, 25.0), std::pair(10.0, 400.0)}) {
    const Drive drive = slalom(configuration, 20.0, wheel_rate, steering_rate);
    const std::vector<OdometryUpdate> updates = run(configuration, drive.messages);
    EXPECT_EQ(updates.size(), drive.truth.size());
    EXPECT_LT(largestDeparture(updates, drive), 1e-3) << wheel_rate << " Hz wheels";
    largest = std::max(largest, largestDeparture(updates, drive));
  }
  recordFigure("1:40 and 40:1: the same path to %.2f mm/m", 1e3 * largest);
}

TEST(Steering, S5_N9_waiting_wheels_are_bounded) {
  OdometryConfiguration configuration = cycab();
  configuration.limits.steering_wait = durationFromSeconds(10.0);
  Bench bench(configuration);
  bench.step(0.0, all(0));
  int accepted = 0;
  for (int i = 1; i <= 3000; ++i)
    if (bench.wheels(i * 0.001, all(i)) == Verdict::kAccepted) ++accepted;
  EXPECT_EQ(accepted, 2048);
  EXPECT_EQ(bench.pipeline.counts()[Verdict::kOverflow], 952u);
  bench.steer(3.0, 0.0);
  for (int i = 0; i < accepted; ++i) ASSERT_TRUE(bench.next(3.0));
  EXPECT_FALSE(bench.next(3.0));
  const auto update = bench.step(3.001, all(3001));
  EXPECT_NEAR(update->report.distance, 0.3001, 1e-9) << "cumulative counters lose nothing";
}

}  // namespace
}  // namespace bs_car_odometry::bench
