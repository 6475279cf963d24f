// Stamps and clocks (docs/reliability.md, T rows), and what reset, restart, rebaseTime and setPose keep.

#include "bench.hpp"
#include "support/figure.hpp"

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <random>

namespace bs_car_odometry::bench {
namespace {

constexpr double kPeriod = 0.02;  // s

/// A pipeline that has driven n steps of 10 mm straight ahead.
Bench driven(int n) {
  Bench bench;
  for (int i = 0; i <= n; ++i) EXPECT_TRUE(bench.step(i * kPeriod, all(100 * i)));
  return bench;
}

std::uint64_t dropped(const Bench& bench, Verdict verdict) { return bench.pipeline.counts()[verdict]; }

TEST(Stamps, T1_stamp_zero_is_dropped) {
  Bench bench = driven(2);
  EXPECT_EQ(bench.pipeline.addWheels({Time(), at(1.0), all(300)}), Verdict::kStampZero);
  EXPECT_EQ(bench.pipeline.addSteering(Axle::kFront, Time(), at(1.0), 0.1), Verdict::kStampZero);
  EXPECT_FALSE(bench.next(10.0));
  EXPECT_EQ(dropped(bench, Verdict::kStampZero), 2u);
  const auto good = bench.step(1.0, all(300));
  ASSERT_TRUE(good);
  EXPECT_NEAR(good->report.step, 0.01, 1e-12);
}

TEST(Stamps, T2_repeated_wheels_are_dropped) {
  Bench bench = driven(2);
  EXPECT_EQ(bench.wheels(2 * kPeriod, all(300)), Verdict::kRepeated);
  EXPECT_FALSE(bench.next(10.0));
  // Also while the first one still waits.
  EXPECT_EQ(bench.wheels(1.0, all(300)), Verdict::kAccepted);
  EXPECT_EQ(bench.wheels(1.0, all(300)), Verdict::kRepeated);
  EXPECT_TRUE(bench.next(10.0));
  EXPECT_FALSE(bench.next(10.0));
  EXPECT_EQ(dropped(bench, Verdict::kRepeated), 2u);
}

TEST(Stamps, T2_repeated_steering_keeps_the_first) {
  Bench bench;
  EXPECT_EQ(bench.steer(0.0, 0.1), Verdict::kAccepted);
  EXPECT_EQ(bench.steer(0.0, 0.3), Verdict::kRepeated);
  bench.wheels(0.0, all(0));
  EXPECT_EQ(bench.next(0.0)->report.steering_angle.front, 0.1);
}

TEST(Stamps, T3_out_of_order_wheels_are_dropped) {
  Bench bench = driven(2);
  EXPECT_EQ(bench.wheels(kPeriod / 2, all(300), 1.0), Verdict::kOutOfOrder);
  EXPECT_FALSE(bench.next(10.0));
  EXPECT_EQ(dropped(bench, Verdict::kOutOfOrder), 1u);
}

/// Messages with some of them received a second time, and steering received up to 50 ms late.
/// A reading that is overtaken by the next one is missed by a step that the next one completes: the path is
/// that of the sorted run to within what a straight line through three readings leaves.
TEST(Stamps, T2_T3_repeats_and_shuffled_steering_equal_the_sorted_run) {
  OdometryConfiguration configuration = cycab();
  configuration.limits.steering_wait = durationFromSeconds(0.1);
  const Drive drive = slalom(configuration, 20.0, 50.0, 50.0);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> delay(0.0, 0.05);
  std::bernoulli_distribution repeat(0.1);
  std::vector<Message> disturbed;
  for (Message message : drive.messages) {
    if (!message.isWheels() && message.stamp > 0.0) message.receipt += delay(random);
    disturbed.push_back(message);
    message.receipt += 0.004;
    if (repeat(random)) disturbed.push_back(message);
  }
  std::stable_sort(disturbed.begin(), disturbed.end(),
                   [](const Message& a, const Message& b) { return a.receipt < b.receipt; });

  const std::vector<OdometryUpdate> sorted = run(configuration, drive.messages);
  const std::vector<OdometryUpdate> shuffled = run(configuration, disturbed);
  ASSERT_EQ(sorted.size(), shuffled.size());
  double largest = 0.0;
  EXPECT_GT(shuffled.back().report.counts[Verdict::kRepeated], 50u);
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    ASSERT_EQ(sorted[i].stamp, shuffled[i].stamp);
    const double apart = (sorted[i].estimate.pose.vector() - shuffled[i].estimate.pose.vector()).norm();
    ASSERT_LT(apart, 5e-4) << i;
    largest = std::max(largest, apart);
  }
  recordFigure("10 %% repeats and a shuffle of 50 ms: within %.2f mm of the sorted run", 1e3 * largest);
}

TEST(Stamps, T4_future_stamp_is_dropped) {
  Bench bench = driven(2);
  EXPECT_EQ(bench.wheels(3600.0, all(300), 0.06), Verdict::kFuture);
  EXPECT_EQ(bench.steer(3600.0, 0.1, 0.06), Verdict::kFuture);
  EXPECT_EQ(bench.pipeline.counts().ahead, durationFromSeconds(3599.94));
  EXPECT_FALSE(bench.next(10.0));
  EXPECT_EQ(dropped(bench, Verdict::kFuture), 2u);
  EXPECT_EQ(bench.wheels(0.161, all(300), 0.06), Verdict::kFuture) << "max_future is 0.1 s";
  const auto good = bench.step(0.06, all(300));
  ASSERT_TRUE(good) << "the clock of the wheels is not spoilt";
  EXPECT_NEAR(good->report.step, 0.01, 1e-12);
  EXPECT_EQ(bench.wheels(0.18, all(400), 0.08), Verdict::kAccepted) << "just within max_future";
}

TEST(Clock, T5_restart_is_bit_identical) {
  const Drive drive = slalom(cycab(), 10.0, 50.0, 20.0);
  OdometryPipeline pipeline(cycab());
  const std::vector<OdometryUpdate> first = run(pipeline, drive.messages);
  ASSERT_GT(first.size(), 400u);
  for (int loop = 0; loop < 20; ++loop) {
    pipeline.restart();
    EXPECT_FALSE(pipeline.started());
    EXPECT_FALSE(pipeline.hasSteering(Axle::kFront));
    ASSERT_TRUE(identical(first, run(pipeline, drive.messages))) << loop;
  }
  recordFigure("20 restarts, identical in every bit");
  pipeline.restart();
  pipeline.addWheels({at(0.0), at(0.0), all(0)});
  EXPECT_FALSE(pipeline.next(at(100.0))) << "steering of the run before is forgotten";
}

TEST(Clock, T6_rebase_keeps_the_pose) {
  Bench bench = driven(200);
  const auto before = bench.step(201 * kPeriod, all(100 * 201));
  bench.pipeline.rebaseTime();
  const double earlier = 201 * kPeriod - 2.0;
  const auto still = bench.step(earlier, all(100 * 201));
  ASSERT_TRUE(still) << "older stamps than before are good now";
  EXPECT_EQ(still->estimate.pose.vector(), before->estimate.pose.vector());
  EXPECT_EQ(still->estimate.twist, Eigen::Vector3d::Zero()) << "the interval is not known";
  EXPECT_EQ(still->estimate.twist_covariance(0, 0), 25.0);
  const auto moving = bench.step(earlier + kPeriod, all(100 * 202));
  EXPECT_NEAR(moving->report.step, 0.01, 1e-12);
  EXPECT_NEAR(moving->estimate.twist.x(), 0.5, 1e-9);
}

TEST(Clock, T7_step_forward_keeps_the_counted_distance_and_has_no_twist) {
  Bench bench = driven(2);
  const auto update = bench.step(3600.0, all(300));
  ASSERT_TRUE(update);
  EXPECT_NEAR(update->report.step, 0.01, 1e-12);
  EXPECT_EQ(update->report.counts.gaps, 1u);
  EXPECT_EQ(update->estimate.twist, Eigen::Vector3d::Zero());
  EXPECT_EQ(update->estimate.twist_covariance(0, 0), 25.0);
  recordFigure("1 h forward: a step of %.0f mm, as counted", 1e3 * update->report.step);
}

TEST(Reset, goes_back_to_the_initial_pose_and_keeps_the_steering) {
  Bench bench = driven(10);
  bench.pipeline.reset();
  EXPECT_FALSE(bench.pipeline.started());
  EXPECT_EQ(bench.pipeline.counts().wheel_messages, 0u);
  EXPECT_TRUE(bench.pipeline.hasSteering(Axle::kFront));
  bench.wheels(1.0, all(99999));
  const auto first = bench.next(2.0);
  ASSERT_TRUE(first);
  const InitialPose initial = cycab().initial_pose;
  EXPECT_EQ(first->estimate.pose.vector(), Eigen::Vector3d(initial.x, initial.y, initial.yaw));
  EXPECT_EQ(first->estimate.pose_covariance, initial.covariance);
  EXPECT_EQ(first->estimate.twist, Eigen::Vector3d::Zero());
  EXPECT_EQ(first->report.distance, 0.0);
  EXPECT_EQ(first->report.counts.wheel_messages, 1u);
}

TEST(Reset, drops_what_waits) {
  Bench bench = driven(2);
  bench.wheels(0.1, all(300));
  EXPECT_TRUE(bench.pipeline.deadline());
  bench.pipeline.reset();
  EXPECT_FALSE(bench.pipeline.deadline());
  EXPECT_FALSE(bench.next(10.0));
}

TEST(SetPose, puts_the_car_there_and_forgets_the_past) {
  Bench bench = driven(10);
  const Eigen::Matrix3d covariance = Eigen::Vector3d(0.01, 0.02, 0.03).asDiagonal();
  bench.pipeline.setPose({10.0, 20.0, M_PI / 2}, covariance);
  const auto parked = bench.step(1.0, all(1000));
  EXPECT_EQ(parked->estimate.pose.vector(), Eigen::Vector3d(10.0, 20.0, M_PI / 2));
  EXPECT_EQ(parked->estimate.pose_covariance, covariance) << "Phi is cleared, no tick, no growth";
  EXPECT_NEAR(parked->report.distance, 0.1, 1e-12) << "distance goes on";
  EXPECT_EQ(parked->report.counts.wheel_messages, 12u);
  const auto moved = bench.step(1.0 + kPeriod, all(1100));
  EXPECT_NEAR(moved->estimate.pose.y, 20.01, 1e-9);
  EXPECT_NEAR(moved->estimate.twist.x(), 0.5, 1e-9);
}

TEST(SetPose, before_the_first_message_is_where_the_run_begins) {
  Bench bench;
  bench.pipeline.setPose({3.0, 4.0, 0.0}, Eigen::Matrix3d::Zero());
  EXPECT_EQ(bench.step(0.0, all(7))->estimate.pose.vector(), Eigen::Vector3d(3.0, 4.0, 0.0));
}

/// Eigenvalues that are negative by their rounding are accepted; none is published.
TEST(SetPose, O2_no_negative_variance_is_published) {
  Bench bench = driven(1);
  Eigen::Matrix3d covariance;
  covariance << 1.0, 1.0 + 4e-10, 0.0, 1.0 + 4e-10, 1.0, 0.0, 0.0, 0.0, 0.1;
  bench.pipeline.setPose({}, covariance);
  const Eigen::Matrix3d published = bench.step(1.0, all(100))->estimate.pose_covariance;
  EXPECT_EQ(published, published.transpose());
  EXPECT_GE(published.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-15);
  EXPECT_TRUE(published.isApprox(covariance, 1e-9));
  EXPECT_EQ(bench.pipeline.counts().covariance_repairs, 1u) << "and it is said";
  bench.pipeline.setPose({}, Eigen::Matrix3d::Identity());
  bench.pipeline.setPose({}, Eigen::Matrix3d::Zero());
  bench.step(2.0, all(200));
  EXPECT_EQ(bench.pipeline.counts().covariance_repairs, 1u) << "of what is none, and of nothing else";
}

// The rule of degree five has weights below zero: far outside its reach, where a heading is known to several
// radians, what it adds up to is no covariance.
TEST(SetPose, O2_repairs_of_exact_moments_are_counted) {
  OdometryConfiguration configuration = cycab();
  configuration.options.uncertainty = Uncertainty::kExactMoments;
  configuration.noise.systematic = {0.5, 0.5, 0.5, 0.5};
  Bench bench(configuration);
  std::optional<OdometryUpdate> last;
  for (int i = 0; i <= 2000; ++i) {
    last = bench.step(i * kPeriod, all(500 * i), 0.3);
    ASSERT_TRUE(last);
    const Eigen::Matrix3d& published = last->estimate.pose_covariance;
    const Eigen::Vector3d eigenvalues = published.selfadjointView<Eigen::Lower>().eigenvalues();
    ASSERT_GE(eigenvalues.minCoeff(), -1e-12 * eigenvalues.maxCoeff());
  }
  EXPECT_GT(last->report.counts.covariance_repairs, 0u);
}

}  // namespace
}  // namespace bs_car_odometry::bench
