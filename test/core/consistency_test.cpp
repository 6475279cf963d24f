// Covariance and chi-square against draws of the very noise that they claim (docs/model.md, section 6).
#include "support/matchers.hpp"
#include "support/seeded_generator.hpp"
#include "vehicles.hpp"

#include "bs_car_odometry/core/odometry_estimator.hpp"

#include <Eigen/Dense>

#include <tuple>

namespace bs_car_odometry {
namespace {

using namespace test_support;

/// A statistic of n draws is taken to be wrong beyond this many of its standard deviations; once in 2000
/// tests by chance, and the seed is fixed.
constexpr double kDeviations = 3.5;

struct NoisyStep {
  StepReadings readings;  ///< what the sensors say
  BodyMotion truth;       ///< what the car did
};

/// Draws one step of an Ackermann car: wheels, front angle, law of the rear axle and side slip of both axles,
/// all around what the angle `phi` asks for.
class NoisyCar {
 public:
  NoisyCar(const Vehicle& vehicle, const NoiseModel& noise, double phi, double travel, unsigned seed)
      : vehicle_(vehicle), noise_(noise), travel_(travel), generator_(seed) {
    steering_ = slaved(vehicle, phi);
    nominal_ = bodyTwist(vehicle, travel, steering_);
    equations_ = fitEquations(FitGeometry(vehicle), steering_);
    axle_travel_ = travel * Eigen::Array2d(1.0 / std::cos(steering_.front), 1.0 / std::cos(steering_.rear));
    // Body motion for one metre of side slip of either axle, base_link's travel along x being as it is.
    sideways_ = equations_.H.bottomRightCorner<2, 2>().inverse();
  }

  NoisyStep draw() {
    NoisyStep step;
    step.truth = nominal_;
    step.truth.tail<2>() += sideways_ * Eigen::Vector2d(slip(0), slip(1));
    const Eigen::Vector4d rolled = equations_.H.topRows<4>() * step.truth;
    for (std::size_t i = 0; i < kWheels; ++i) {
      const double travel = rolled(static_cast<Eigen::Index>(i));
      step.readings.travel.values[i] = travel + generator_.normal(noise_.wheel.variance() * std::abs(travel));
    }
    // The truth is at steering_; the sensor errs, and the rear axle stands off its law by as much as is
    // drawn.
    const double front = steering_.front + generator_.normal(angleVariance(noise_.steering.angle.std(), 0));
    const double rear =
        vehicle_.rear_steering.angle(front) + generator_.normal(angleVariance(noise_.rear_law.std(), 1));
    step.readings.begin = step.readings.end = {front, rear};
    return step;
  }

 private:
  double slip(Eigen::Index axle) { return generator_.normal(noise_.lateral.variance() * axle_travel_(axle)); }
  double angleVariance(double std, Eigen::Index axle) const {
    return std * std * noise_.steering.correlation_length / axle_travel_(axle);
  }

  Vehicle vehicle_;
  NoiseModel noise_;
  double travel_;
  SeededGenerator generator_;
  SteeringAngles steering_;
  BodyMotion nominal_;
  FitEquations equations_;
  Eigen::Array2d axle_travel_;
  Eigen::Matrix2d sideways_;
};

/// Fine ticks: rounding is in the weights but not drawn.
Vehicle fineTicks(Vehicle vehicle) {
  vehicle.metres_per_tick.values.fill(1e-6);
  return vehicle;
}

/// The Cycab with phi_rear = slope phi_front.
Vehicle cycabWithRearLaw(double slope) {
  Vehicle vehicle = fineTicks(cycab());
  vehicle.rear_steering.coefficients = {0.0, slope};
  return vehicle;
}

/// Front angle, and slope of the rear law: the share of the one sensor's error that the axles have in common.
class ChiSquare : public testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(ChiSquare, HasThreeDegreesOfFreedom) {
  constexpr int kDraws = 20000;
  const auto [phi, slope] = GetParam();
  const Vehicle vehicle = cycabWithRearLaw(slope);
  const WheelFit fit(vehicle, NoiseModel());
  NoisyCar car(vehicle, NoiseModel(), phi, 0.05, 11);
  double sum = 0.0;
  int beyond_5_percent = 0;
  int beyond_1_percent = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double chi_square = fit.increment(car.draw().readings).residuals.chi_square;
    sum += chi_square;
    beyond_5_percent += chi_square > 7.814728 ? 1 : 0;
    beyond_1_percent += chi_square > 11.344867 ? 1 : 0;
  }
  const auto binomial = [](double p) { return kDeviations * std::sqrt(p * (1.0 - p) / kDraws); };
  EXPECT_NEAR(sum / kDraws, 3.0, kDeviations * std::sqrt(6.0 / kDraws));
  EXPECT_NEAR(beyond_5_percent / static_cast<double>(kDraws), 0.05, binomial(0.05));
  EXPECT_NEAR(beyond_1_percent / static_cast<double>(kDraws), 0.01, binomial(0.01));
}

INSTANTIATE_TEST_SUITE_P(AnglesAndLaws, ChiSquare,
                         testing::Combine(testing::Values(0.0, 0.25, -0.25, 0.4),
                                          testing::Values(-1.0, -0.3, 0.8)));

/// The step's covariance is that of many draws of the step: each entry against its own sampling error, for
/// which sqrt(2) of the product of both deviations is an upper bound.
class StepCovariance : public testing::TestWithParam<double> {};

TEST_P(StepCovariance, IsThatOfTheDraws) {
  constexpr int kDraws = 400000;
  const Vehicle vehicle = cycabWithRearLaw(GetParam());
  const WheelFit fit(vehicle, NoiseModel());
  NoisyCar car(vehicle, NoiseModel(), 0.5, 0.05, 12);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const NoisyStep step = car.draw();
    const Eigen::Vector3d error = fit.increment(step.readings).motion - step.truth;
    sum += error * error.transpose();
  }
  const Eigen::Matrix3d expected =
      fit.increment(consistentReadings(vehicle, 0.05, slaved(vehicle, 0.5))).path_covariance;
  const Eigen::Vector3d sigma = expected.diagonal().cwiseSqrt();
  const Eigen::Matrix3d scale = (sigma * sigma.transpose()).cwiseInverse();
  EXPECT_TRUE(matrixNear((sum / kDraws).cwiseProduct(scale), expected.cwiseProduct(scale),
                         kDeviations * std::sqrt(2.0 / kDraws)));
}

INSTANTIATE_TEST_SUITE_P(RearLaws, StepCovariance, testing::Values(-1.0, -0.3, 0.8));

/// (W2): the weights do not follow the readings, so that a noisy circle is not shorter or tighter than it is.
TEST(NoisyCircle, IsUnbiasedAndConsistent) {
  constexpr int kRuns = 1000;
  constexpr int kSteps = 400;  // of 0.05 m
  OdometryConfiguration configuration;
  configuration.vehicle = fineTicks(cycab());
  configuration.noise.systematic = {0.0, 0.0, 0.0, 0.0};
  NoisyCar car(configuration.vehicle, configuration.noise, 0.25, 0.05, 13);

  Eigen::Vector3d error_sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_sum = Eigen::Matrix3d::Zero();
  double nees_sum = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    OdometryEstimator estimator(configuration);
    Pose2 truth;
    for (int i = 0; i < kSteps; ++i) {
      const NoisyStep step = car.draw();
      truth = truth * exp(step.truth);
      ASSERT_TRUE(estimator.step(step.readings, std::nullopt));
    }
    const Eigen::Vector3d error = estimator.estimate().pose.vector() - truth.vector();
    const Eigen::Matrix3d& covariance = estimator.estimate().pose_covariance;
    error_sum += error;
    covariance_sum += covariance;
    nees_sum += error.dot(covariance.ldlt().solve(error));
  }
  const Eigen::Vector3d sigma = (covariance_sum / kRuns).diagonal().cwiseSqrt();
  const Eigen::Vector3d bias = (error_sum / kRuns).cwiseQuotient(sigma);
  EXPECT_LT(bias.cwiseAbs().maxCoeff(), kDeviations / std::sqrt(kRuns)) << bias.transpose();
  EXPECT_NEAR(nees_sum / kRuns, 3.0, kDeviations * std::sqrt(6.0 / kRuns));
}

/// (S1) on one step of T2 from the covariance of T6, wheels and angle drawn, through the axle model itself.
TEST(FirstOrderStep, AgreesWithDraws) {
  constexpr int kDraws = 100000;
  Vehicle vehicle = withMeasuredRear(pivotCar());
  vehicle.base_link_x = 0.0;
  NoiseModel noise = noNoise();
  noise.wheel = 0.006;
  noise.steering = {0.003, 0.5};  // fresh in a step of half a metre
  const AxleOdometry odometry(vehicle, noise, OdometryOptions(), Axle::kRear);
  StepReadings readings;
  readings.travel[Wheel::kRearRight] = 0.55;
  readings.travel[Wheel::kRearLeft] = 0.45;
  readings.begin.rear = readings.end.rear = -0.3;
  const Pose2 start{1.0, 2.0, 0.7};
  Eigen::Matrix3d initial;
  initial << 4e-4, 1e-4, 5e-5, 1e-4, 3e-4, -4e-5, 5e-5, -4e-5, 1e-4;

  const BodyIncrement increment = odometry.increment(readings);
  const PoseStep moved = advance(start, increment.motion);
  FirstOrderCovariance covariance(initial);
  covariance.advance(moved, increment.path_covariance, SystematicSensitivity::Zero());

  SeededGenerator generator(14);
  const Eigen::Matrix3d root = initial.llt().matrixL();
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d begin =
        start.vector() +
        root * Eigen::Vector3d(generator.normal(1.0), generator.normal(1.0), generator.normal(1.0));
    StepReadings noisy = readings;
    for (double& travel : noisy.travel.values) travel += generator.normal(noise.wheel.variance() * travel);
    noisy.begin.rear = noisy.end.rear = -0.3 + generator.normal(0.003 * 0.003);
    const Pose2 end = advance({begin.x(), begin.y(), begin.z()}, odometry.increment(noisy).motion).pose;
    const Eigen::Vector3d error = end.vector() - moved.pose.vector();
    sum += error * error.transpose();
  }
  const Eigen::Vector3d sigma = covariance.total().diagonal().cwiseSqrt();
  const Eigen::Matrix3d scale = (sigma * sigma.transpose()).cwiseInverse();
  EXPECT_TRUE(matrixNear((sum / kDraws).cwiseProduct(scale), covariance.total().cwiseProduct(scale),
                         kDeviations * std::sqrt(2.0 / kDraws)));
}

}  // namespace
}  // namespace bs_car_odometry
