#include "bs_car_odometry/core/odometry_estimator.hpp"

#include "support/matchers.hpp"
#include "vehicles.hpp"

#include <limits>

namespace bs_car_odometry {
namespace {

using namespace test_support;

const Duration kInterval = durationFromSeconds(0.02);

OdometryConfiguration cycabConfiguration() {
  OdometryConfiguration configuration;
  configuration.vehicle = cycab();
  configuration.initial_pose = {1.0, 2.0, 0.5, Eigen::Vector3d(1e-4, 2e-4, 3e-4).asDiagonal()};
  return configuration;
}

void drive(OdometryEstimator& estimator, int steps) {
  const StepReadings readings = consistentReadings(cycab(), 0.02, slaved(cycab(), 0.2));
  for (int i = 0; i < steps; ++i) ASSERT_TRUE(estimator.step(readings, kInterval));
}

/// (max_speed, max_speed, max_speed/wheelbase)^2 of the default limits: the twist is not known.
Eigen::Matrix3d unknownTwistCovariance() {
  return Eigen::Vector3d(1600.0, 1600.0, 1600.0 / 1.44).asDiagonal();
}

void expectUnknownTwist(const OdometryEstimator& estimator) {
  EXPECT_EQ(estimator.estimate().twist, Eigen::Vector3d::Zero());
  EXPECT_TRUE(matrixRelativelyNear(estimator.estimate().twist_covariance, unknownTwistCovariance(), 1e-15));
}

TEST(OdometryEstimator, BeginsAtTheInitialPose) {
  const OdometryEstimator estimator(cycabConfiguration());
  EXPECT_EQ(estimator.estimate().pose.vector(), Eigen::Vector3d(1.0, 2.0, 0.5));
  EXPECT_EQ(estimator.estimate().pose_covariance.diagonal(), Eigen::Vector3d(1e-4, 2e-4, 3e-4));
  expectUnknownTwist(estimator);
}

TEST(OdometryEstimator, SetPoseForgetsTheParametersToo) {
  OdometryEstimator estimator(cycabConfiguration());
  drive(estimator, 50);
  ASSERT_GT(firstOrder(estimator).sensitivity().norm(), 1e-4);
  const Eigen::Matrix3d covariance = Eigen::Vector3d(0.01, 0.02, 0.03).asDiagonal();
  estimator.setPose({5.0, 6.0, 7.0}, covariance);
  EXPECT_EQ(estimator.estimate().pose.vector(), Eigen::Vector3d(5.0, 6.0, 7.0));
  EXPECT_EQ(estimator.estimate().pose_covariance, covariance);
  EXPECT_EQ(firstOrder(estimator).sensitivity(), SystematicSensitivity::Zero());
  expectUnknownTwist(estimator);
}

TEST(OdometryEstimator, ResetIsAFreshStart) {
  OdometryEstimator estimator(cycabConfiguration());
  OdometryEstimator fresh(cycabConfiguration());
  drive(estimator, 50);
  estimator.reset();
  EXPECT_EQ(estimator.residuals().chi_square, 0.0);
  drive(estimator, 10);
  drive(fresh, 10);
  EXPECT_EQ(estimator.estimate().pose.vector(), fresh.estimate().pose.vector());
  EXPECT_EQ(estimator.estimate().pose_covariance, fresh.estimate().pose_covariance);
}

TEST(OdometryEstimator, TwistIsTheIncrementOverTheInterval) {
  OdometryEstimator estimator(cycabConfiguration());
  drive(estimator, 1);
  const Eigen::Vector3d expected = bodyTwist(cycab(), 1.0, slaved(cycab(), 0.2));
  EXPECT_TRUE(matrixNear(estimator.estimate().twist, expected, 1e-12));
  EXPECT_TRUE(isCovariance(estimator.estimate().twist_covariance));
}

TEST(OdometryEstimator, TwistCovarianceHoldsRoundingAndParameters) {
  OdometryConfiguration configuration = cycabConfiguration();
  configuration.noise = noNoise();
  configuration.options.axles = AxleSelection::kRear;
  const StepReadings straight = consistentReadings(cycab(), 0.02, {});
  OdometryEstimator rounding_alone(configuration);
  ASSERT_TRUE(rounding_alone.step(straight, kInterval));
  // Two wheels, each with tick^2/6: their mean over 0.02 s.
  EXPECT_TRUE(
      relativelyNear(rounding_alone.estimate().twist_covariance(0, 0), 1e-8 / 6.0 / 2.0 / 4e-4, 1e-12));
  // and none of it in the pose.
  EXPECT_EQ(rounding_alone.lastIncrement().path_covariance, Eigen::Matrix3d::Zero());

  configuration.noise.systematic.k_r = configuration.noise.systematic.k_l = 0.01;
  OdometryEstimator with_parameters(configuration);
  ASSERT_TRUE(with_parameters.step(straight, kInterval));
  // 1 % of each wheel at 1 m/s.
  EXPECT_TRUE(relativelyNear(with_parameters.estimate().twist_covariance(0, 0),
                             1e-8 / 6.0 / 2.0 / 4e-4 + 1e-4 / 2.0, 1e-12));
}

TEST(OdometryEstimator, NoIntervalLeavesNoTwistButMoves) {
  for (const std::optional<Duration> interval :
       {std::optional<Duration>(), std::optional<Duration>(Duration::zero()),
        std::optional<Duration>(-kInterval)}) {
    OdometryEstimator estimator(cycabConfiguration());
    const Pose2 before = estimator.estimate().pose;
    drive(estimator, 1);
    ASSERT_TRUE(estimator.step(consistentReadings(cycab(), 0.02, {}), interval));
    EXPECT_GT((estimator.estimate().pose.position() - before.position()).norm(), 0.03);
    expectUnknownTwist(estimator);
  }
}

TEST(OdometryEstimator, RefusesAStepThatIsNotFinite) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (const AxleSelection axles : {AxleSelection::kBoth, AxleSelection::kRear}) {
      OdometryConfiguration configuration = cycabConfiguration();
      configuration.options.axles = axles;
      OdometryEstimator estimator(configuration);
      drive(estimator, 10);
      const OdometryEstimate before = estimator.estimate();
      const SystematicSensitivity sensitivity = firstOrder(estimator).sensitivity();
      StepReadings broken = consistentReadings(cycab(), 0.02, {});
      broken.travel[Wheel::kRearLeft] = bad;
      EXPECT_FALSE(estimator.step(broken, kInterval));
      EXPECT_EQ(estimator.estimate().pose.vector(), before.pose.vector());
      EXPECT_EQ(firstOrder(estimator).sensitivity(), sensitivity);
      // Unseen motion of up to 40 m/s for 0.02 s: 0.8 m, and 0.8/1.2 rad.
      const Eigen::Vector3d grown =
          (estimator.estimate().pose_covariance - before.pose_covariance).diagonal();
      EXPECT_TRUE(matrixRelativelyNear(grown, Eigen::Vector3d(0.64, 0.64, 0.64 / 1.44), 1e-12));
      expectUnknownTwist(estimator);
      EXPECT_EQ(estimator.residuals().chi_square, 0.0);
      drive(estimator, 1);  // and goes on
    }
}

TEST(OdometryEstimator, RefusesASteeringAngleThatIsNotFinite) {
  OdometryEstimator estimator(cycabConfiguration());
  StepReadings broken = consistentReadings(cycab(), 0.02, {});
  broken.end.front = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(estimator.step(broken, std::nullopt));
  EXPECT_TRUE(estimator.estimate().pose.isFinite());
}

TEST(OdometryEstimator, InflationOfTheHeadingEndsAtHalfATurn) {
  OdometryEstimator estimator(cycabConfiguration());
  estimator.inflate(durationFromSeconds(10.0));
  EXPECT_TRUE(relativelyNear(estimator.estimate().pose_covariance(2, 2), 3e-4 + M_PI * M_PI, 1e-12));
  EXPECT_TRUE(relativelyNear(estimator.estimate().pose_covariance(0, 0), 1e-4 + 160000.0, 1e-12));
}

TEST(OdometryEstimator, NewSystematicCovarianceKeepsThePast) {
  OdometryEstimator estimator(cycabConfiguration());
  drive(estimator, 50);
  const Eigen::Matrix3d before = estimator.estimate().pose_covariance;
  estimator.setSystematicCovariance(SystematicCovariance::Zero());
  EXPECT_EQ(firstOrder(estimator).total(), before);
  drive(estimator, 50);
  EXPECT_EQ(firstOrder(estimator).sensitivity(), SystematicSensitivity::Zero());
}

/// (L L^T, whole and singular): the root gives the covariance back.
TEST(SystematicRoot, MultipliesBackToTheCovariance) {
  SystematicCovariance mixed;
  for (Eigen::Index i = 0; i < mixed.rows(); ++i)
    for (Eigen::Index j = 0; j < mixed.cols(); ++j)
      mixed(i, j) = std::sin(static_cast<double>(1 + i * 8 + j)) / static_cast<double>(1 + i + j);
  const SystematicCovariance regular = mixed * mixed.transpose();
  SystematicCovariance singular = regular;  // parameters 1 and 6 known exactly
  for (const Eigen::Index k : {1, 6}) {
    singular.row(k).setZero();
    singular.col(k).setZero();
  }
  SystematicSensitivity J;
  for (Eigen::Index i = 0; i < J.rows(); ++i)
    for (Eigen::Index j = 0; j < J.cols(); ++j) J(i, j) = std::cos(static_cast<double>(3 * i + 2 * j));
  for (const SystematicCovariance& covariance : {regular, singular, SystematicCovariance(1e-12 * regular)}) {
    const SystematicSensitivity root = SystematicRoot(covariance)(J);
    const Eigen::Matrix3d expected = J * covariance * J.transpose();
    EXPECT_TRUE(matrixNear(root * root.transpose(), expected, 1e-13 * expected.norm()));
  }
}

struct NeededCase {
  AxleSelection axles;
  bool measured;
  std::vector<double> law;
  AxleGeometry geometry;
  double rear_hub;
  bool front;  ///< expected
  bool rear;   ///< expected
};

TEST(SteeringNeeded, Table) {
  constexpr AxleGeometry kAckermann = AxleGeometry::kAckermann;
  constexpr AxleGeometry kPivot = AxleGeometry::kPivot;
  const std::vector<double> opposite{0.0, -1.0};
  const std::vector<double> fixed{0.0};
  const std::vector<double> crooked{0.1};
  const std::vector<NeededCase> cases{
      {AxleSelection::kBoth, false, opposite, kAckermann, 0.0, true, false},
      {AxleSelection::kBoth, true, opposite, kAckermann, 0.0, true, true},
      {AxleSelection::kBoth, false, fixed, kAckermann, 0.0, true, false},
      {AxleSelection::kFront, false, opposite, kAckermann, 0.0, true, false},
      {AxleSelection::kFront, true, opposite, kAckermann, 0.0, true, false},
      {AxleSelection::kRear, false, opposite, kAckermann, 0.0, true, false},
      {AxleSelection::kRear, false, fixed, kAckermann, 0.0, false, false},
      {AxleSelection::kRear, false, crooked, kAckermann, 0.0, false, false},
      {AxleSelection::kRear, true, fixed, kAckermann, 0.0, false, true},
      {AxleSelection::kRear, true, fixed, kAckermann, 0.05, true, true},
      {AxleSelection::kRear, true, fixed, kPivot, 0.05, false, true},
      {AxleSelection::kRear, false, fixed, kAckermann, 0.05, false, false},
      {AxleSelection::kRear, false, crooked, kAckermann, 0.05, true, false},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const NeededCase& c = cases[i];
    Vehicle vehicle = cycab();
    if (c.measured) vehicle = withMeasuredRear(vehicle);
    vehicle.rear_steering.coefficients = c.law;
    vehicle.axle_geometry = c.geometry;
    vehicle.hub_offset.rear = c.rear_hub;
    OdometryOptions options;
    options.axles = c.axles;
    const PerAxle<bool> needed = steeringNeeded(vehicle, options);
    EXPECT_EQ(needed.front, c.front) << "case " << i;
    EXPECT_EQ(needed.rear, c.rear) << "case " << i;
  }
}

}  // namespace
}  // namespace bs_car_odometry
