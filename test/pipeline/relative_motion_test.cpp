// The motion between two stamps as the pipeline keeps it: against the pose of the same drive, through faults.

#include "bench.hpp"
#include "support/matchers.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace bs_car_odometry::bench {
namespace {

using test_support::matrixNear;

constexpr double kPeriod = 0.02;    // s
constexpr double kMaxSpeed = 5.0;   // m/s, the bench's
constexpr double kWheelbase = 1.2;  // m, the bench's

/// The bench's Cycab, at the origin and certain of it: its pose is the motion since the start.
OdometryConfiguration cycabAtOrigin() {
  OdometryConfiguration configuration = cycab();
  configuration.initial_pose = {};
  return configuration;
}

/// 10 mm a step, in a turn.
PerWheel<std::int64_t> counters(int step) { return {{100 * step, 106 * step, 98 * step, 104 * step}}; }

void drive(Bench& bench, int from, int to) {
  for (int i = from; i <= to; ++i) ASSERT_TRUE(bench.step(i * kPeriod, counters(i), 0.1)) << i;
}

std::optional<MotionEstimate> motion(const Bench& bench, double from, double to) {
  return bench.pipeline.motionHistory().between(at(from), at(to));
}

/// The whole history is the pose, in mean and covariance.
void expectIsThePose(const Bench& bench, const OdometryUpdate& update) {
  const std::optional<TimeSpan> span = bench.pipeline.motionHistory().span();
  ASSERT_TRUE(span && span->begin == at(0.0) && span->end == update.stamp);
  const auto whole = bench.pipeline.motionHistory().between(span->begin, span->end);
  ASSERT_TRUE(whole);
  const OdometryEstimate& estimate = update.estimate;
  // The same operations in the same order, on at most some metres.
  EXPECT_TRUE(matrixNear(whole->motion.vector(), estimate.pose.vector(), 1e-13));
  EXPECT_TRUE(
      matrixNear(whole->covariance, estimate.pose_covariance, 1e-13 * estimate.pose_covariance.norm()));
  EXPECT_NEAR(whole->distance, update.report.distance, 1e-12);
}

TEST(RelativeMotion, IsTheMotionOfThePose) {
  OdometryConfiguration configuration = cycab();
  Bench bench(configuration);
  std::vector<Pose2> poses;
  for (int i = 0; i <= 100; ++i) poses.push_back(bench.step(i * kPeriod, counters(i), 0.1)->estimate.pose);
  for (const auto& [from, to] : {std::pair<std::size_t, std::size_t>(0, 100), {30, 31}, {70, 20}}) {
    const auto moved = motion(bench, kPeriod * static_cast<double>(from), kPeriod * static_cast<double>(to));
    ASSERT_TRUE(moved);
    EXPECT_TRUE(matrixNear(moved->motion.vector(), (inverse(poses[from]) * poses[to]).vector(), 1e-13));
  }
}

TEST(RelativeMotion, OfTheWholeDriveIsThePoseOfACertainStart) {
  Bench bench(cycabAtOrigin());
  drive(bench, 0, 99);
  expectIsThePose(bench, *bench.step(100 * kPeriod, counters(100), 0.1));
}

/// Messages lost, and a spike: one longer step.
TEST(RelativeMotion, E3_E5_lostMessagesAreOneStep) {
  Bench bench(cycabAtOrigin());
  drive(bench, 0, 10);
  EXPECT_FALSE(bench.step(12 * kPeriod, all(1 << 30), 0.1));
  drive(bench, 15, 20);
  EXPECT_EQ(bench.pipeline.motionHistory().size(), 16u);
  expectIsThePose(bench, *bench.step(21 * kPeriod, counters(21), 0.1));
}

TEST(RelativeMotion, E2_countersThatRestartAreInTheCovariance) {
  Bench bench(cycabAtOrigin());
  drive(bench, 0, 10);
  EXPECT_FALSE(bench.step(11 * kPeriod, all(1 << 30), 0.1));
  const auto restarted = bench.step(12 * kPeriod, all((1 << 30) + 100), 0.1);
  ASSERT_TRUE(restarted && restarted->report.counts.counter_restarts == 1);
  expectIsThePose(bench, *restarted);
  const auto across = motion(bench, 9 * kPeriod, 12 * kPeriod);
  EXPECT_GT(across->covariance(0, 0), std::pow(kMaxSpeed * kPeriod, 2));
  EXPECT_GT(across->covariance(1, 1), std::pow(kMaxSpeed * kPeriod, 2));
  EXPECT_GT(across->covariance(2, 2), std::pow(kMaxSpeed * kPeriod / kWheelbase, 2));
  EXPECT_EQ(across->unseen, durationFromSeconds(kPeriod));
  EXPECT_LT(motion(bench, 0.0, 10 * kPeriod)->covariance(0, 0), 1e-3) << "before it";
  EXPECT_LT(motion(bench, 11 * kPeriod, 12 * kPeriod)->covariance(0, 0), 1e-3) << "after it";
}

TEST(RelativeMotion, O1_refusedStepsAreInTheCovariance) {
  OdometryConfiguration configuration = cycabAtOrigin();
  configuration.vehicle.gains.rear.k_l = std::nan("");
  Bench bench(configuration);
  drive(bench, 0, 10);
  ASSERT_EQ(bench.pipeline.counts().refused_states, 10u);
  const auto refused = motion(bench, 2 * kPeriod, 7 * kPeriod);
  ASSERT_TRUE(refused);
  EXPECT_NEAR(refused->covariance(0, 0), 5 * std::pow(kMaxSpeed * kPeriod, 2), 1e-15);
  EXPECT_EQ(refused->motion.vector(), Eigen::Vector3d::Zero());
  EXPECT_NEAR(toSeconds(refused->unseen), 5 * kPeriod, 1e-9);
}

/// The counts are there, the steering is not.
TEST(RelativeMotion, E6_gapIsInTheCovariance) {
  Bench bench(cycabAtOrigin());
  drive(bench, 0, 10);
  const double end = 10 * kPeriod + 2.0;
  const auto update = bench.step(end, counters(110), 0.1);
  ASSERT_TRUE(update && update->report.counts.gaps == 1);
  expectIsThePose(bench, *update);
  EXPECT_GT(motion(bench, 10 * kPeriod, end)->covariance(2, 2), 0.1) << "an angle may have been anywhere";
  const auto inside = motion(bench, 10 * kPeriod, 10 * kPeriod + 1.0);
  EXPECT_GT(inside->covariance(0, 0), 0.25 * std::pow(kMaxSpeed * 2.0, 2)) << "half way of an unknown way";
}

TEST(RelativeMotion, S4_staleSteeringIsInTheCovariance) {
  Bench bench(cycabAtOrigin());
  drive(bench, 0, 10);
  std::optional<OdometryUpdate> update;
  for (int i = 11; i <= 60; ++i) {
    bench.wheels(i * kPeriod, counters(i));
    update = bench.next(i * kPeriod + 0.1);
    ASSERT_TRUE(update);
  }
  ASSERT_EQ(update->report.state, OdometryState::kNoSteering);
  expectIsThePose(bench, *update);
  drive(bench, 61, 69);
  expectIsThePose(bench, *bench.step(70 * kPeriod, counters(70), 0.1));
  EXPECT_GT(motion(bench, 20 * kPeriod, 70 * kPeriod)->covariance(2, 2),
            10.0 * motion(bench, 0.0, 20 * kPeriod)->covariance(2, 2));
}

TEST(RelativeMotion, setPoseMovesThePoseAndNotTheCar) {
  Bench put(cycabAtOrigin());
  Bench left(cycabAtOrigin());
  drive(put, 0, 10);
  drive(left, 0, 10);
  put.pipeline.setPose({100.0, -50.0, 2.0}, Eigen::Matrix3d::Identity());
  drive(put, 11, 20);
  drive(left, 11, 20);
  const auto with = motion(put, 3 * kPeriod, 17 * kPeriod);
  const auto without = motion(left, 3 * kPeriod, 17 * kPeriod);
  ASSERT_TRUE(with && without);
  EXPECT_EQ(with->motion.vector(), without->motion.vector());
  EXPECT_EQ(with->covariance, without->covariance);
}

class Cut : public testing::TestWithParam<void (OdometryPipeline::*)()> {};

/// No answer reaches across, and the history goes on with the second message after it.
TEST_P(Cut, ForgetsTheMotion) {
  Bench bench(cycabAtOrigin());
  drive(bench, 0, 10);
  (bench.pipeline.*GetParam())();
  EXPECT_FALSE(bench.pipeline.motionHistory().span());
  drive(bench, 11, 11);
  EXPECT_FALSE(bench.pipeline.motionHistory().span()) << "from where is not known";
  drive(bench, 12, 15);
  EXPECT_EQ(bench.pipeline.motionHistory().span()->begin, at(11 * kPeriod));
  EXPECT_FALSE(motion(bench, 10 * kPeriod, 15 * kPeriod));
  EXPECT_TRUE(motion(bench, 11 * kPeriod, 15 * kPeriod));
}

INSTANTIATE_TEST_SUITE_P(RelativeMotion, Cut,
                         testing::Values(&OdometryPipeline::reset, &OdometryPipeline::restart,
                                         &OdometryPipeline::rebaseTime));

/// Counters that restart in a time whose beginning is not known.
TEST(RelativeMotion, E2_restartInANewTimeBeginsTheHistory) {
  Bench bench(cycabAtOrigin());
  drive(bench, 0, 10);
  bench.pipeline.rebaseTime();
  EXPECT_FALSE(bench.step(11 * kPeriod, all(1 << 30), 0.1));
  ASSERT_TRUE(bench.step(12 * kPeriod, all((1 << 30) + 100), 0.1));
  ASSERT_EQ(bench.pipeline.counts().counter_restarts, 1u);
  EXPECT_EQ(bench.pipeline.motionHistory().span()->begin, at(11 * kPeriod));
}

TEST(RelativeMotion, HistoryIsAsLongAsItsParameter) {
  for (const double seconds : {0.0, 0.2, 1.0}) {
    OdometryConfiguration configuration = cycabAtOrigin();
    configuration.relative_motion.history = durationFromSeconds(seconds);
    Bench bench(configuration);
    drive(bench, 0, 100);
    const std::optional<TimeSpan> span = bench.pipeline.motionHistory().span();
    ASSERT_EQ(span.has_value(), seconds > 0.0);
    EXPECT_NEAR(span ? toSeconds(span->end - span->begin) : 0.0, seconds, 1e-9);
  }
}

}  // namespace
}  // namespace bs_car_odometry::bench
