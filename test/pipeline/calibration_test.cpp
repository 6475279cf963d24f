// Other values of the parameters in the middle of a drive: no jump, and a covariance that stays honest.

#include "bench.hpp"
#include "support/matchers.hpp"
#include "support/seeded_generator.hpp"

#include "bs_car_odometry/core/systematic_prior.hpp"

#include <gtest/gtest.h>

namespace bs_car_odometry::bench {
namespace {

using test_support::matrixNear;
using test_support::SeededGenerator;

constexpr double kPeriod = 0.02;  // s

const Uncertainty kMethods[] = {Uncertainty::kFirstOrder, Uncertainty::kExactMoments,
                                Uncertainty::kClosedForm, Uncertainty::kPaper2Simplified,
                                Uncertainty::kMonteCarlo};

/// 10 mm a step, in a turn.
PerWheel<std::int64_t> counters(int step) { return {{100 * step, 106 * step, 98 * step, 104 * step}}; }

OdometryUpdate drive(Bench& bench, int from, int to) {
  std::optional<OdometryUpdate> update;
  for (int i = from; i <= to; ++i) update = bench.step(i * kPeriod, counters(i), 0.1);
  EXPECT_TRUE(update);
  return update.value_or(OdometryUpdate());
}

/// Of a car that is calibrated well: gains to 0.1 %, each correlated with all others.
OdometryCalibration calibration() {
  OdometryCalibration calibration;
  calibration.gains.front = {1.02, 0.99, 1.03};
  calibration.gains.rear = {0.98, 1.01, 0.97};
  calibration.steering.front = {1.05, -0.02};
  const SystematicCovariance ones = SystematicCovariance::Ones();
  calibration.covariance = 1e-6 * (SystematicCovariance::Identity() + 0.5 * ones);
  return calibration;
}

OdometryConfiguration configured(OdometryConfiguration configuration,
                                 const OdometryCalibration& calibration) {
  configuration.vehicle.gains = calibration.gains;
  configuration.vehicle.steering = calibration.steering;
  configuration.systematic_covariance = calibration.covariance;
  return configuration;
}

class EveryMethod : public ::testing::TestWithParam<Uncertainty> {
 protected:
  OdometryConfiguration configuration() const {
    OdometryConfiguration configuration = cycab();
    configuration.options.uncertainty = GetParam();
    return configuration;
  }
};
INSTANTIATE_TEST_SUITE_P(Uncertainty, EveryMethod, ::testing::ValuesIn(kMethods), [](const auto& row) {
  return "method_" + std::to_string(static_cast<int>(row.param));
});

TEST_P(EveryMethod, PoseAndCovarianceStay) {
  Bench bench(configuration());
  const OdometryUpdate before = drive(bench, 0, 200);
  bench.pipeline.setCalibration(calibration());
  const auto after = bench.step(201 * kPeriod, counters(200), 0.1);
  ASSERT_TRUE(after);
  // A weighted sum of matrices is taken apart and put together again.
  const Eigen::Matrix3d& covariance = before.estimate.pose_covariance;
  EXPECT_TRUE(matrixNear(after->estimate.pose_covariance, covariance, 1e-12 * covariance.norm()));
  EXPECT_TRUE(matrixNear(after->estimate.pose.vector(), before.estimate.pose.vector(), 0.0));
  EXPECT_EQ(after->report.distance, before.report.distance);
}

/// Were the errors new ones after each exchange, fifty of them would leave a seventh of the deviation.
TEST_P(EveryMethod, TheSameCalibrationAgainChangesNothing) {
  const OdometryConfiguration calibrated = configured(configuration(), calibration());
  Bench once(calibrated);
  Bench often(calibrated);
  const OdometryUpdate expected = drive(once, 0, 1000);
  for (int i = 0; i < 50; ++i) {
    drive(often, 20 * i, 20 * i + 19);
    often.pipeline.setCalibration(calibration());
  }
  const OdometryUpdate update = drive(often, 1000, 1000);
  // Moments beyond the second are dropped with each exchange (2e-4 here), and particles keep their parameters
  // in single precision.
  const Eigen::Matrix3d& covariance = expected.estimate.pose_covariance;
  EXPECT_TRUE(matrixNear(update.estimate.pose_covariance, covariance, 2e-3 * covariance.norm()));
}

TEST(Calibration, HoldsForWhatHasNotMovedTheCarYet) {
  Bench from_start(configured(cycab(), calibration()));
  Bench later(cycab());
  for (Bench* bench : {&from_start, &later}) bench->step(0.0, counters(0), 0.2);
  // The reading and the counters that are there belong to the step that comes.
  for (Bench* bench : {&from_start, &later}) bench->steer(0.01, 0.3);
  later.pipeline.setCalibration(calibration());
  for (int i = 1; i <= 100; ++i) {
    const auto expected = from_start.step(i * kPeriod, counters(i), 0.1);
    const auto update = later.step(i * kPeriod, counters(i), 0.1);
    ASSERT_TRUE(expected && update);
    ASSERT_TRUE(identical(update->estimate, expected->estimate)) << i;
  }
}

/// The steering at the reference is known by its reading alone once the buffer is empty.
TEST(Calibration, HoldsForTheReadingsBeforeTheClockWentBack) {
  Bench from_start(configured(cycab(), calibration()));
  Bench later(cycab());
  for (Bench* bench : {&from_start, &later}) bench->step(10.0, counters(0), 0.2);
  later.pipeline.setCalibration(calibration());
  std::optional<OdometryUpdate> updates[2];
  for (Bench* bench : {&from_start, &later}) {
    bench->pipeline.rebaseTime();
    updates[bench == &later ? 1 : 0] = bench->step(1.0, counters(1), 0.1);
  }
  ASSERT_TRUE(updates[0] && updates[1]);
  EXPECT_TRUE(identical(updates[1]->estimate, updates[0]->estimate));
}

TEST(Calibration, StaysWithResets) {
  Bench from_start(configured(cycab(), calibration()));
  Bench later(cycab());
  drive(later, 0, 10);
  later.pipeline.setCalibration(calibration());
  later.pipeline.restart();
  const OdometryUpdate expected = drive(from_start, 0, 100);
  EXPECT_TRUE(identical(drive(later, 0, 100).estimate, expected.estimate));
}

/// No angle leaves the limit because of a scale.
TEST(Calibration, KeepsToTheSteeringLimit) {
  Bench bench(cycab());
  bench.step(0.0, counters(0), 1.2);
  OdometryCalibration wide = calibration();
  wide.steering.front.scale = 2.0;
  bench.pipeline.setCalibration(wide);
  bench.wheels(kPeriod, counters(1));
  const auto update = bench.next(1.0);
  ASSERT_TRUE(update);
  EXPECT_LE(std::abs(update->report.steering_angle.front), cycab().limits.steering_limit);
  EXPECT_TRUE(isFinite(*update));
}

/// Gains that differ from 1 by up to twice so much, an offset of so much.
OdometryCalibration changedBy(double change) {
  OdometryCalibration calibration;
  calibration.gains.front = {1.0 + 0.5 * change, 1.0 - 0.5 * change, 1.0 + change};
  calibration.gains.rear = {1.0 - change, 1.0 + 0.5 * change, 1.0 - 0.5 * change};
  calibration.steering.front.offset = change;
  calibration.covariance = 1e-6 * SystematicCovariance::Identity();
  return calibration;
}

struct Departure {
  double motion;
  double covariance;  ///< as a part of it
};

/// What sets a history that was put right apart from that of a car with these values from the start on.
Departure departureOfHistory(const OdometryCalibration& calibration) {
  // With all wheels the weights change too, where the wheels do not agree.
  OdometryConfiguration rear = cycab();
  rear.options.axles = AxleSelection::kRear;
  Bench bench(rear);
  Bench expected(configured(rear, calibration));
  drive(bench, 0, 200);
  drive(expected, 0, 200);
  bench.pipeline.setCalibration(calibration);
  const auto motion = bench.pipeline.motionHistory().between(at(0.5), at(3.5));
  const auto exact = expected.pipeline.motionHistory().between(at(0.5), at(3.5));
  EXPECT_TRUE(motion && exact);
  if (!motion || !exact) return {};
  return {(motion->motion.vector() - exact->motion.vector()).norm(),
          (motion->covariance - exact->covariance).norm() / exact->covariance.norm()};
}

TEST(Calibration, TheHistoryIsThatOfACarWithTheNewValues) {
  const Departure half = departureOfHistory(changedBy(0.001));
  const Departure whole = departureOfHistory(changedBy(0.002));
  // Of second order in the change: a quarter for half of it, but for the third order.
  EXPECT_NEAR(whole.motion / half.motion, 4.0, 0.1);
  EXPECT_LT(whole.motion, 1e-4) << "1.5 m, which first order moves by 3e-3";
  EXPECT_LT(whole.covariance, 0.02) << "sensitivities are those at the values before";
}

TEST(Calibration, AHistoryWithAnotherScaleBeginsAnew) {
  Bench bench(cycab());
  drive(bench, 0, 200);
  bench.pipeline.setCalibration(calibration());
  EXPECT_EQ(bench.pipeline.motionHistory().size(), 0u);
}

/// Errors of the parameters alone.
OdometryConfiguration withoutNoise() {
  OdometryConfiguration configuration = cycab();
  configuration.noise.wheel = configuration.noise.lateral = configuration.noise.rear_law = 0.0;
  configuration.noise.steering.angle = 0.0;
  configuration.initial_pose.covariance.setZero();
  return configuration;
}

SystematicCovariance anyCovariance(SeededGenerator& random) {
  SystematicCovariance B;
  for (Eigen::Index i = 0; i < B.size(); ++i) B(i) = random.normal(1e-4);
  return B * B.transpose();
}

/// Yaw sensitivity over some steps: the same in each, since yaw is linear in the parameters.
Eigen::Matrix<double, 1, systematic::kCount> turn(OdometryEstimator& estimator, int steps) {
  Eigen::Matrix<double, 1, systematic::kCount> J = Eigen::Matrix<double, 1, systematic::kCount>::Zero();
  for (int i = 0; i < steps; ++i) {
    StepReadings readings;
    readings.travel = {{0.0100, 0.0106, 0.0098, 0.0104}};
    readings.begin.front = readings.end.front = 0.1;
    readings.begin.rear = readings.end.rear = -0.1;
    EXPECT_TRUE(estimator.step(readings, std::nullopt));
    J += estimator.lastIncrement().J_motion_systematic.row(2);
  }
  return J;
}

/// E[(j_1 e + j_2 e')^2] with E[e e^T] = S, E[e' e'^T] = S' and E[e e'^T] = shared.
TEST(Calibration, CarriesOnTheErrorThatIsStillThere) {
  SeededGenerator random(31);
  for (int i = 0; i < 20; ++i) {
    const SystematicCovariance S = anyCovariance(random);
    // A measurement of h e: what is found is independent of what is left, so that E[e e'^T] = S'.
    Eigen::Matrix<double, systematic::kCount, 1> h;
    for (Eigen::Index k = 0; k < h.size(); ++k) h[k] = random.normal(1.0);
    const SystematicCovariance after = S - S * h * h.transpose() * S / (h.dot(S * h) + 1e-5);
    for (const auto& [next, shared] : {std::pair<SystematicCovariance, SystematicCovariance>{after, after},
                                       {0.25 * S, 0.25 * S},
                                       {4.0 * S, S},
                                       {SystematicCovariance::Zero(), SystematicCovariance::Zero()}}) {
      OdometryEstimator estimator(withoutNoise());
      estimator.setSystematicCovariance(S);
      const auto j_1 = turn(estimator, 50);
      estimator.setSystematicCovariance(next);
      const auto j_2 = turn(estimator, 100);
      const double expected =
          (j_1 * S * j_1.transpose() + (2.0 * j_1 * shared + j_2 * next) * j_2.transpose()).value();
      // Roots of covariances lose half of the digits of their smallest eigenvalues.
      EXPECT_NEAR(estimator.estimate().pose_covariance(2, 2) / expected, 1.0, 1e-7) << i;
    }
  }
}

/// Parameters that a calibration does not list keep their shape; their draws need no Gaussian.
TEST(Calibration, LeavesOtherParametersTheirDistribution) {
  OdometryConfiguration configuration = cycab();
  configuration.noise.systematic.k_b = Distribution::uniform(0.05);
  SystematicCovariance covariance = systematicCovariance(configuration.noise.systematic);
  covariance(systematic::kRearTrack, systematic::kRearTrack) = 1e-6;
  configuration.systematic_covariance = covariance;
  const SystematicPrior prior(configuration);
  EXPECT_EQ(prior.shape[systematic::kFrontTrack].shape(), Distribution::Shape::kUniform);
  EXPECT_EQ(prior.shape[systematic::kRearTrack].shape(), Distribution::Shape::kGaussian);
  EXPECT_TRUE(matrixNear(prior.root.matrix() * prior.root.matrix().transpose(), covariance, 1e-18));
}

}  // namespace
}  // namespace bs_car_odometry::bench
