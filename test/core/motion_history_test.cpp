// Motion between two stamps from the kept steps, against an estimator that starts at the first of them.
#include "support/matchers.hpp"
#include "support/numerical_derivative.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/motion_history.hpp"
#include "bs_car_odometry/core/odometry_estimator.hpp"

#include <limits>
#include <string>
#include <tuple>

namespace bs_car_odometry {
namespace {

using namespace test_support;

constexpr std::size_t kSteps = 200;
constexpr double kTravel = 0.05;  // m a step
constexpr Duration kPeriod = std::chrono::milliseconds(20);
constexpr Time kStart = timeFromNanoseconds(1600000000000000000);
constexpr Duration kMinute = std::chrono::seconds(60);

/// The same operations in the same order: rounding alone, and that only where the compiler regroups them.
constexpr double kRounding = 1e-13;

Time after(double steps) { return kStart + durationFromSeconds(toSeconds(kPeriod) * steps); }

TimeSpan spanOf(std::size_t step) {
  return {after(static_cast<double>(step)), after(static_cast<double>(step + 1))};
}

/// Two periods of a slalom, the steering moving within each step; reverse in its second half.
std::vector<StepReadings> slalom(const Vehicle& vehicle) {
  const auto angles = [&](std::size_t i) {
    return slaved(vehicle, 0.3 * std::sin(4.0 * M_PI * static_cast<double>(i) / kSteps));
  };
  std::vector<StepReadings> drive(kSteps);
  for (std::size_t i = 0; i < kSteps; ++i) {
    const double travel = 3 * i < 2 * kSteps ? kTravel : -kTravel;
    drive[i].begin = angles(i);
    drive[i].end = angles(i + 1);
    drive[i].travel = wheelSpeeds(vehicle, bodyTwist(vehicle, travel, drive[i].mean()), drive[i].mean());
  }
  return drive;
}

/// The angle of every sensor is doubted in some steps, twice.
PerAxle<double> doubtIn(std::size_t step) {
  if (step >= 30 && step < 50) return {0.02, 0.01};
  if (step >= 120 && step < 130) return {0.05, 0.0};
  return {};
}

OdometryConfiguration configurationOf(const Vehicle& vehicle, AxleSelection axles, const NoiseModel& noise) {
  OdometryConfiguration configuration;
  configuration.vehicle = vehicle;
  configuration.options.axles = axles;
  configuration.noise = noise;
  return configuration;
}

MotionHistory emptyHistory(const NoiseModel& noise, Duration longest = kMinute,
                           std::size_t most_steps = MotionHistory::kMostSteps) {
  return MotionHistory(longest, systematicCovariance(noise.systematic), most_steps);
}

/// Drives steps [from, to) with an estimator and keeps them in a history.
void drive(OdometryEstimator& estimator, const std::vector<StepReadings>& readings, std::size_t from,
           std::size_t to, bool doubt, MotionHistory* history = nullptr) {
  for (std::size_t i = from; i < to; ++i) {
    const PerAxle<double> sigma = doubt ? doubtIn(i) : PerAxle<double>();
    ASSERT_TRUE(estimator.step(readings[i], kPeriod));
    estimator.doubtSteering(kPeriod, sigma);
    if (history) history->addStep(spanOf(i), estimator.lastIncrement(), sigma, Eigen::Vector3d::Zero());
  }
}

MotionHistory historyOf(const OdometryConfiguration& configuration, const std::vector<StepReadings>& readings,
                        bool doubt = false) {
  MotionHistory history = emptyHistory(configuration.noise);
  OdometryEstimator estimator(configuration);
  drive(estimator, readings, 0, readings.size(), doubt, &history);
  return history;
}

MotionEstimate between(const MotionHistory& history, double from, double to) {
  const std::optional<MotionEstimate> motion = history.between(after(from), after(to));
  EXPECT_TRUE(motion) << from << " to " << to;
  return motion.value_or(MotionEstimate());
}

testing::AssertionResult sameMotion(const MotionEstimate& motion, const OdometryEstimate& expected) {
  // Of a drive of 10 m.
  const auto pose = matrixNear(motion.motion.vector(), expected.pose.vector(), 10.0 * kRounding);
  if (!pose) return pose;
  return matrixNear(motion.covariance, expected.pose_covariance, kRounding * expected.pose_covariance.norm());
}

using Case = std::tuple<Vehicle, AxleSelection>;

class History : public testing::TestWithParam<Case> {
 protected:
  History()
      : configuration_(configurationOf(std::get<0>(GetParam()), std::get<1>(GetParam()), NoiseModel())),
        readings_(slalom(configuration_.vehicle)) {}

  void withNoise(const NoiseModel& noise) { configuration_.noise = noise; }

  OdometryConfiguration configuration_;
  std::vector<StepReadings> readings_;
};

TEST_P(History, EqualsAnEstimatorThatStartsThere) {
  for (const bool doubt : {false, true}) {
    const MotionHistory history = historyOf(configuration_, readings_, doubt);
    for (const auto& [from, to] : {std::pair(0, 200), {0, 1}, {40, 45}, {45, 125}, {60, 110}, {110, 200}}) {
      OdometryEstimator fresh(configuration_);
      drive(fresh, readings_, from, to, doubt);
      const MotionEstimate motion = between(history, from, to);
      EXPECT_TRUE(sameMotion(motion, fresh.estimate())) << from << " to " << to << (doubt ? ", doubt" : "");
      EXPECT_TRUE(isCovariance(motion.covariance));
      EXPECT_EQ(motion.unseen, Duration::zero());
    }
  }
}

/// J1 and J2 of a motion composed of two.
std::pair<Eigen::Matrix3d, Eigen::Matrix3d> compositionJacobians(const Pose2& ab, const Pose2& bc) {
  const Pose2 ac = ab * bc;
  Eigen::Matrix3d J1 = Eigen::Matrix3d::Identity();
  J1(0, 2) = ab.y - ac.y;
  J1(1, 2) = ac.x - ab.x;
  Eigen::Matrix3d J2 = Eigen::Matrix3d::Identity();
  J2.topLeftCorner<2, 2>() << std::cos(ab.yaw), -std::sin(ab.yaw), std::sin(ab.yaw), std::cos(ab.yaw);
  return {J1, J2};
}

/// Independent noise: what is known of a to b and of b to c adds up to what is known of a to c.
TEST_P(History, NoiseComposes) {
  NoiseModel noise;
  noise.systematic = {0.0, 0.0, 0.0, 0.0};
  withNoise(noise);
  const MotionHistory history = historyOf(configuration_, readings_);
  for (const double middle : {11.0, 80.0, 150.0, 189.0}) {
    const MotionEstimate ab = between(history, 10, middle);
    const MotionEstimate bc = between(history, middle, 190);
    const MotionEstimate ac = between(history, 10, 190);
    const auto [J1, J2] = compositionJacobians(ab.motion, bc.motion);
    // Sums of some 200 steps in another order.
    EXPECT_TRUE(matrixNear((ab.motion * bc.motion).vector(), ac.motion.vector(), 1e-13));
    EXPECT_TRUE(matrixNear(J1 * ab.covariance * J1.transpose() + J2 * bc.covariance * J2.transpose(),
                           ac.covariance, 1e-12 * ac.covariance.norm()));
    EXPECT_NEAR(ab.distance + bc.distance, ac.distance, 1e-12);
  }
}

constexpr double kGainSigma = 0.01;  // of the right rear wheel, the only parameter with an error

/// The slalom of a Cycab on its rear axle, whose right wheel is `k_r` times as large.
MotionHistory historyWithGain(double k_r) {
  SystematicCovariance A = SystematicCovariance::Zero();
  A(systematic::kRearRight, systematic::kRearRight) = kGainSigma * kGainSigma;
  MotionHistory history(kMinute, A);
  std::vector<StepReadings> readings = slalom(cycab());
  for (StepReadings& step : readings) step.travel[Wheel::kRearRight] *= k_r;
  OdometryEstimator estimator(configurationOf(cycab(), AxleSelection::kRear, noNoise()));
  drive(estimator, readings, 0, readings.size(), false, &history);
  return history;
}

/// What an error of one standard deviation does to the motion, by driving with a wheel that is larger, and
/// one that is smaller. Central differences: h^2 times a third derivative below 1e4 (20 m), 1e-16/h of
/// rounding.
Eigen::Vector3d drivenEffect(double from, double to) {
  constexpr double h = 1e-6;
  return kGainSigma / (2.0 * h) *
         (between(historyWithGain(1.0 + h), from, to).motion.vector() -
          between(historyWithGain(1.0 - h), from, to).motion.vector());
}

/// The same from the covariance, whose only part is that of this error; the sign is that of `guess`.
Eigen::Vector3d effectOf(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& guess) {
  Eigen::Index largest = 0;
  covariance.diagonal().maxCoeff(&largest);
  const Eigen::Vector3d effect = covariance.col(largest) / std::sqrt(covariance(largest, largest));
  return effect.dot(guess) < 0.0 ? Eigen::Vector3d(-effect) : effect;
}

/// The same error in every interval: effects add up, and not their squares.
TEST(SystematicMotion, ComposesFullyCorrelated) {
  const MotionHistory history = historyWithGain(1.0);
  const auto checkedEffect = [&](double from, double to) {
    const Eigen::Vector3d driven = drivenEffect(from, to);
    const Eigen::Vector3d effect = effectOf(between(history, from, to).covariance, driven);
    EXPECT_TRUE(matrixNear(effect, driven, 1e-6 * driven.norm())) << from << " to " << to;
    return effect;
  };
  for (const double middle : {70.0, 100.4}) {
    const auto [J1, J2] =
        compositionJacobians(between(history, 10, middle).motion, between(history, middle, 190).motion);
    const Eigen::Vector3d whole = checkedEffect(10, 190);
    // The root of a covariance has half its digits where the effect is small.
    EXPECT_TRUE(matrixNear(J1 * checkedEffect(10, middle) + J2 * checkedEffect(middle, 190), whole,
                           1e-10 * whole.norm()));
  }
}

/// The twist of a step is constant: any part of it lies on its arc, and two parts make the whole.
TEST_P(History, InsideAStep) {
  const MotionHistory history = historyOf(configuration_, readings_);
  OdometryEstimator estimator(configuration_);
  drive(estimator, readings_, 0, 8, false);
  const BodyIncrement increment = estimator.lastIncrement();  // of step 7
  for (const double part : {0.1, 0.5, 0.95}) {
    const MotionEstimate motion = between(history, 7.0, 7.0 + part);
    EXPECT_TRUE(matrixNear(motion.motion.vector(), exp(part * increment.motion).vector(), 1e-14));
    EXPECT_NEAR(motion.distance, part * increment.motion.head<2>().norm(), 1e-15);
    const Pose2 whole = motion.motion * between(history, 7.0 + part, 8.0).motion;
    EXPECT_TRUE(matrixNear(whole.vector(), between(history, 7.0, 8.0).motion.vector(), 1e-14));
  }
  const MotionEstimate ab = between(history, 10.0, 100.3);
  const MotionEstimate bc = between(history, 100.3, 190.0);
  const MotionEstimate ac = between(history, 10.0, 190.0);
  EXPECT_TRUE(matrixNear((ab.motion * bc.motion).vector(), ac.motion.vector(), 1e-13));
}

TEST_P(History, NoiseInsideAStepComposes) {
  NoiseModel noise;
  noise.systematic = {0.0, 0.0, 0.0, 0.0};
  withNoise(noise);
  const MotionHistory history = historyOf(configuration_, readings_);
  for (const double middle : {100.3, 120.5, 150.99}) {
    const MotionEstimate ab = between(history, 10, middle);
    const MotionEstimate bc = between(history, middle, 190);
    const MotionEstimate ac = between(history, 10, 190);
    const auto [J1, J2] = compositionJacobians(ab.motion, bc.motion);
    // Cut in two, a step of 5 cm has its heading noise at two places: half a step of lever arm in 10 m.
    EXPECT_TRUE(matrixNear(J1 * ab.covariance * J1.transpose() + J2 * bc.covariance * J2.transpose(),
                           ac.covariance, 1e-3 * ac.covariance.norm()));
  }
}

TEST_P(History, BackIsTheInverse) {
  const MotionHistory history = historyOf(configuration_, readings_);
  const MotionEstimate there = between(history, 20.5, 170);
  const MotionEstimate back = between(history, 170, 20.5);
  EXPECT_TRUE(matrixNear((there.motion * back.motion).vector(), Eigen::Vector3d::Zero(), 1e-14));
  EXPECT_EQ(back.distance, there.distance);
  const Eigen::Matrix3d J = numericalDerivative<3, 3>(
      [](const Eigen::Vector3d& x) {
        return inverse(Pose2{x.x(), x.y(), x.z()}).vector();
      },
      there.motion.vector());
  // The derivative is good to about 1e-11 of 10 m.
  EXPECT_TRUE(
      matrixNear(back.covariance, J * there.covariance * J.transpose(), 1e-9 * back.covariance.norm()));
  EXPECT_TRUE(isCovariance(back.covariance));
}

TEST_P(History, NoTimeNoMotion) {
  const MotionHistory history = historyOf(configuration_, readings_);
  for (const double stamp : {0.0, 50.0, 50.5, 200.0}) {
    const MotionEstimate motion = between(history, stamp, stamp);
    EXPECT_EQ(motion.motion.vector(), Eigen::Vector3d::Zero());
    EXPECT_EQ(motion.covariance, Eigen::Matrix3d::Zero());
    EXPECT_EQ(motion.distance, 0.0);
  }
}

std::string nameOf(const testing::TestParamInfo<Case>& info) {
  const AxleSelection axles = std::get<1>(info.param);
  return std::get<0>(info.param).name + (axles == AxleSelection::kBoth ? "Both" : "Rear");
}

INSTANTIATE_TEST_SUITE_P(FourGeometries, History,
                         testing::Combine(testing::ValuesIn(fourGeometries()),
                                          testing::Values(AxleSelection::kBoth, AxleSelection::kRear)),
                         nameOf);

/// Steps of the Cycab straight ahead.
BodyIncrement straight() {
  BodyIncrement increment;
  increment.motion = {kTravel, 0.0, 0.0};
  increment.path_covariance = Eigen::Vector3d(1e-6, 2e-6, 3e-6).asDiagonal();
  return increment;
}

void addStraight(MotionHistory& history, std::size_t from, std::size_t to) {
  for (std::size_t i = from; i < to; ++i) history.addStep(spanOf(i), straight(), {}, Eigen::Vector3d::Zero());
}

/// Step 10 was not seen.
TEST(UnseenMotion, IsInEveryIntervalThatContainsIt) {
  const Eigen::Matrix3d unseen = Eigen::Vector3d(0.04, 0.04, 0.01).asDiagonal();
  MotionHistory history = emptyHistory(noNoise());
  addStraight(history, 0, 10);
  history.addUnseen(spanOf(10), unseen);
  addStraight(history, 11, 21);

  FirstOrderCovariance expected(Eigen::Matrix3d::Zero());
  const auto go = [&](double travel, const Eigen::Matrix3d& noise) {
    PoseStep step;
    step.dx = travel;
    step.q = 0.5 * travel;
    expected.advance(step, noise, SystematicSensitivity::Zero());
  };
  for (int i = 0; i < 5; ++i) go(kTravel, straight().path_covariance);
  expected.inflate(unseen);
  for (int i = 0; i < 5; ++i) go(kTravel, straight().path_covariance);
  const MotionEstimate motion = between(history, 5, 16);
  EXPECT_TRUE(matrixNear(motion.covariance, expected.total(), 1e-15));
  EXPECT_NEAR(motion.motion.x, 10 * kTravel, 1e-14);
  EXPECT_EQ(motion.unseen, kPeriod);

  EXPECT_EQ(between(history, 0, 10).unseen, Duration::zero());
  EXPECT_LT(between(history, 0, 10).covariance(0, 0), 1e-3);
  EXPECT_EQ(between(history, 11, 21).unseen, Duration::zero());
  EXPECT_LT(between(history, 11, 21).covariance(0, 0), 1e-3);
  const MotionEstimate part = between(history, 10.25, 10.75);
  EXPECT_TRUE(matrixNear(part.covariance, 0.5 * unseen, 1e-15)) << "in proportion of the time";
  EXPECT_EQ(part.unseen, kPeriod / 2);
}

/// The error of a doubted angle is one and the same before and after it: its effects add up.
TEST(UnseenMotion, DoesNotEndADoubt) {
  BodyIncrement doubted;
  doubted.motion = {kTravel, 0.0, 0.0};
  doubted.J_motion_systematic(2, systematic::kFrontOffset) = 0.1;
  MotionHistory history = emptyHistory(noNoise());
  history.addStep(spanOf(0), doubted, {0.02, 0.0}, Eigen::Vector3d::Zero());
  history.addUnseen(spanOf(1), Eigen::Matrix3d::Zero());
  history.addStep(spanOf(2), doubted, {0.02, 0.0}, Eigen::Vector3d::Zero());
  EXPECT_NEAR(between(history, 0, 3).covariance(2, 2), std::pow(2 * 0.1 * 0.02, 2), 1e-18);
}

/// After a gap the sum is known and the way there is not.
TEST(Gap, StampsInsideAreAsUncertainAsTheMotionIsUnknown) {
  const Eigen::Vector3d within(0.09, 0.09, 0.04);
  MotionHistory history = emptyHistory(noNoise());
  addStraight(history, 0, 1);
  history.addStep(spanOf(1), straight(), {}, within);
  addStraight(history, 2, 3);
  const Eigen::Matrix3d P = straight().path_covariance;
  EXPECT_LT(between(history, 1, 2).covariance.trace(), 2.0 * P.trace()) << "nothing at its ends";
  const Eigen::Matrix3d half = 0.25 * within.asDiagonal().toDenseMatrix();
  EXPECT_TRUE(matrixNear(between(history, 1, 1.5).covariance, half, P.trace())) << "a quarter at half time";
  EXPECT_TRUE(matrixNear(between(history, 1.5, 2).covariance, half, P.trace()));
  EXPECT_GT(between(history, 1.5, 3).covariance(0, 0), half(0, 0));
  EXPECT_GT(between(history, 0, 1.5).covariance(0, 0), half(0, 0));
}

TEST(Ring, N9_HoldsTheNewestSteps) {
  constexpr std::size_t kMost = 16;
  MotionHistory history = emptyHistory(noNoise(), kMinute, kMost);
  MotionHistory large = emptyHistory(noNoise());
  for (std::size_t i = 0; i < 5 * kMost; ++i) {
    addStraight(history, i, i + 1);
    addStraight(large, i, i + 1);
    ASSERT_EQ(history.size(), std::min(i + 1, kMost));
    const std::size_t oldest = i + 1 - history.size();
    ASSERT_EQ(history.span()->begin, spanOf(oldest).begin);
    ASSERT_EQ(history.span()->end, spanOf(i).end);
    const auto motion = history.between(history.span()->begin, history.span()->end);
    const auto expected = large.between(history.span()->begin, history.span()->end);
    ASSERT_TRUE(motion && expected);
    ASSERT_EQ(motion->motion.vector(), expected->motion.vector());
    ASSERT_EQ(motion->covariance, expected->covariance);
    ASSERT_FALSE(history.between(history.span()->begin - Duration(1), history.span()->end));
  }
}

TEST(Ring, HoldsWhatIsYoungEnough) {
  MotionHistory history = emptyHistory(noNoise(), 10 * kPeriod);
  addStraight(history, 0, 100);
  EXPECT_EQ(history.size(), 10u);
  EXPECT_EQ(history.span()->end - history.span()->begin, 10 * kPeriod);
  // A step that is longer than the history is kept whole.
  history.addStep({after(100), after(200)}, straight(), {}, Eigen::Vector3d::Zero());
  EXPECT_EQ(history.size(), 1u);
  EXPECT_EQ(history.span()->begin, after(100));
}

TEST(Refused, NothingKnown) {
  MotionHistory history = emptyHistory(noNoise());
  EXPECT_FALSE(history.span());
  EXPECT_FALSE(history.between(kStart, kStart));
  addStraight(history, 0, 5);
  history.clear();
  EXPECT_FALSE(history.span());
  EXPECT_FALSE(history.between(after(1), after(2)));
}

TEST(Refused, NothingKept) {
  MotionHistory history = emptyHistory(noNoise(), Duration::zero());
  addStraight(history, 0, 5);
  history.addUnseen(spanOf(5), Eigen::Matrix3d::Identity());
  EXPECT_EQ(history.size(), 0u);
  EXPECT_FALSE(history.between(after(1), after(2)));
}

TEST(Refused, StampsOutside) {
  MotionHistory history = emptyHistory(noNoise());
  addStraight(history, 0, 5);
  const Duration tick(1);
  EXPECT_TRUE(history.between(after(0), after(5)));
  EXPECT_FALSE(history.between(after(0) - tick, after(5)));
  EXPECT_FALSE(history.between(after(0), after(5) + tick));
  EXPECT_FALSE(history.between(after(5) + tick, after(0)));
  EXPECT_FALSE(history.between(after(5), after(0) - tick));
  EXPECT_FALSE(history.between(Time(), Time(Duration(std::numeric_limits<std::int64_t>::max()))));
}

TEST(Refused, StepsThatDoNotFollowBeginAnew) {
  MotionHistory history = emptyHistory(noNoise());
  addStraight(history, 0, 5);
  addStraight(history, 6, 8);
  EXPECT_EQ(history.span()->begin, after(6));
  EXPECT_EQ(history.size(), 2u);
}

TEST(Refused, WhatIsNotFinite) {
  BodyIncrement huge;
  huge.path_covariance.diagonal().setConstant(0.75 * std::numeric_limits<double>::max());
  MotionHistory history = emptyHistory(noNoise());
  for (std::size_t i = 0; i < 2; ++i) history.addStep(spanOf(i), huge, {}, Eigen::Vector3d::Zero());
  EXPECT_TRUE(history.between(after(0), after(1)));
  EXPECT_FALSE(history.between(after(0), after(2)));
}

}  // namespace
}  // namespace bs_car_odometry
