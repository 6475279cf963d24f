#include "bs_car_odometry/core/particle_plan.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

namespace {

/// No angle is tried further away than this from what was read [rad]: steering_limit stays below pi/2.
constexpr double kFarthestAngle = 0.25;
constexpr double kLargestKurtosis = 9.0;

bool isPlainGaussian(const Distribution& distribution) {
  return distribution.shape() == Distribution::Shape::kGaussian &&
         distribution.truncation() == Distribution::kNotTruncated;
}

/// L with L L^T = A, also where A is singular.
Eigen::Matrix3d lowerRoot(const Eigen::Matrix3d& A) {
  Eigen::Matrix3d L = Eigen::Matrix3d::Zero();
  for (Eigen::Index j = 0; j < 3; ++j) {
    double pivot = A(j, j);
    for (Eigen::Index k = 0; k < j; ++k) pivot -= L(j, k) * L(j, k);
    if (pivot <= A(j, j) * 1e-14) continue;
    L(j, j) = std::sqrt(pivot);
    for (Eigen::Index i = j + 1; i < 3; ++i) {
      double rest = A(i, j);
      for (Eigen::Index k = 0; k < j; ++k) rest -= L(i, k) * L(j, k);
      L(i, j) = rest / L(j, j);
    }
  }
  return L;
}

std::array<float, 9> rows(const Eigen::Matrix3d& M) {
  std::array<float, 9> values;
  Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(values.data()) = M.cast<float>();
  return values;
}

bool isSlaved(const OdometryConfiguration& c) {
  return c.vehicle.rear_steering.source == RearSteering::Source::kPolynomial;
}

PerAxle<Distribution> angleErrors(const OdometryConfiguration& c) {
  PerAxle<Distribution> errors;
  if (c.options.axles != AxleSelection::kRear || isSlaved(c)) errors.front = c.noise.steering.angle;
  if (c.options.axles != AxleSelection::kFront)
    errors.rear = isSlaved(c) ? c.noise.rear_law : c.noise.steering.angle;
  return errors;
}

ReferenceStep referenceStep(const UncertainStep& step) {
  const double yaw = step.moved.pose.yaw - step.increment.motion.z();
  return {std::cos(yaw), std::sin(yaw), step.moved.dx, step.moved.dy, step.increment.motion.z()};
}

}  // namespace

ParticlePlanner::ParticlePlanner(const OdometryConfiguration& configuration)
    : wheel_(configuration.noise.wheel),
      lateral_(configuration.noise.lateral),
      rear_steering_(configuration.vehicle.rear_steering),
      angle_error_(angleErrors(configuration)),
      has_offset_{configuration.options.axles != AxleSelection::kRear || isSlaved(configuration),
                  configuration.options.axles != AxleSelection::kFront && !isSlaved(configuration)} {
  setOffsets({});
}

/// The motions are tried where a parabola through three of them gets variance and mean right up to the fourth
/// order of the error e: at E[e^4]/E[e^2] = reach^2.
void ParticlePlanner::setOffsets(const PerAxle<double>& std) {
  for (const Axle axle : kAllAxles) {
    const double held = angle_error_[axle].variance();
    const double offset = has_offset_[axle] ? std[axle] * std[axle] : 0.0;
    const double kurtosis = std::min(angle_error_[axle].kurtosis(), kLargestKurtosis);
    const double fourth = kurtosis * held * held + 6.0 * held * offset + 3.0 * offset * offset;
    reach_[axle] = held + offset > 0.0 ? std::min(std::sqrt(fourth / (held + offset)), kFarthestAngle) : 0.0;
  }
}

ParticlePlan ParticlePlanner::plan(const UncertainStep& step) const {
  using namespace systematic;
  ParticlePlan plan;
  plan.reference = referenceStep(step);
  Eigen::Map<Eigen::Vector3f>(plan.motion.data()) = step.increment.motion.cast<float>();
  plan.gains.front = rows(step.increment.J_motion_systematic.middleCols<3>(kFrontRight));
  plan.gains.rear = rows(step.increment.J_motion_systematic.middleCols<3>(kRearRight));
  const StepNoise noise =
      std::visit([&](const auto& model) { return model.noiseSources(step.readings); }, step.model);
  plan.angle_path = noise.axle_path;
  planNoise(noise, plan);
  planAngles(step, plan);
  return plan;
}

/// A sum of Gaussian errors is one: three numbers serve for all of them.
void ParticlePlanner::planNoise(const StepNoise& noise, ParticlePlan& plan) const {
  Eigen::Matrix3d gaussian = Eigen::Matrix3d::Zero();
  const auto add = [&](const Distribution& distribution, const Eigen::Vector3d& column, double path) {
    if (distribution.std() == 0.0 || path == 0.0) return;
    if (isPlainGaussian(distribution)) {
      gaussian += distribution.variance() * path * column * column.transpose();
    } else {
      plan.sources[plan.source_count++] = {&distribution, (std::sqrt(path) * column).cast<float>()};
    }
  };
  for (const Wheel wheel : kAllWheels)
    add(wheel_, noise.J_motion_wheel.col(static_cast<Eigen::Index>(index(wheel))), noise.wheel_path[wheel]);
  for (const Axle axle : kAllAxles)
    add(lateral_, noise.J_motion_slip.col(static_cast<Eigen::Index>(index(axle))), noise.axle_path[axle]);
  plan.has_gaussian = !gaussian.isZero(0.0);
  plan.gaussian = rows(lowerRoot(gaussian));
}

/// The model itself with errors in the angles, which both ends of the step share.
BodyMotion ParticlePlanner::motionWith(const UncertainStep& step, double front_error,
                                       double rear_error) const {
  StepReadings readings = step.readings;
  for (SteeringAngles* angles : {&readings.begin, &readings.end}) {
    if (rear_steering_.source == RearSteering::Source::kPolynomial)
      angles->rear += rear_steering_.angle(angles->front + front_error) - rear_steering_.angle(angles->front);
    angles->front += front_error;
    angles->rear += rear_error;
  }
  return std::visit([&](const auto& model) { return model.increment(readings).motion; }, step.model);
}

void ParticlePlanner::planAngles(const UncertainStep& step, ParticlePlan& plan) const {
  const BodyMotion& t = step.increment.motion;
  Eigen::Matrix<double, 3, 5> C = Eigen::Matrix<double, 3, 5>::Zero();
  const double f = reach_.front;
  const double r = reach_.rear;
  const auto fit = [&t](double reach, const BodyMotion& plus, const BodyMotion& minus, auto coefficients) {
    coefficients.col(0) = (plus - minus) / (2.0 * reach);
    coefficients.col(1) = (plus + minus - 2.0 * t) / (2.0 * reach * reach);
  };
  if (f > 0.0) fit(f, motionWith(step, f, 0.0), motionWith(step, -f, 0.0), C.middleCols<2>(0));
  if (r > 0.0) fit(r, motionWith(step, 0.0, r), motionWith(step, 0.0, -r), C.middleCols<2>(2));
  if (f > 0.0 && r > 0.0)
    C.col(4) = (motionWith(step, f, r) + motionWith(step, -f, -r) -
                2.0 * (t + C.col(1) * f * f + C.col(3) * r * r)) /
               (2.0 * f * r);
  if (!C.allFinite()) C.setZero();
  Eigen::Map<Eigen::Matrix<float, 3, 5, Eigen::RowMajor>>(plan.angles.data()) = C.cast<float>();
}

}  // namespace bs_car_odometry
