#include "bs_car_odometry/core/wheel_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bs_car_odometry {

namespace {

/// Variance that keeps R regular where nothing moves: that of a micrometre, finer than the ticks of encoders
/// [m^2]. Wheel joints, whose resolution is not known, have only this.
constexpr double kFloorVariance = 1e-12;

/// Cofactors of a symmetric 3x3 matrix: its inverse times its determinant.
Eigen::Matrix3d symmetricAdjugate(const Eigen::Matrix3d& A) {
  Eigen::Matrix3d C;
  C(0, 0) = A(1, 1) * A(2, 2) - A(1, 2) * A(1, 2);
  C(0, 1) = C(1, 0) = A(1, 2) * A(0, 2) - A(0, 1) * A(2, 2);
  C(0, 2) = C(2, 0) = A(0, 1) * A(1, 2) - A(1, 1) * A(0, 2);
  C(1, 1) = A(0, 0) * A(2, 2) - A(0, 2) * A(0, 2);
  C(1, 2) = C(2, 1) = A(0, 1) * A(0, 2) - A(0, 0) * A(1, 2);
  C(2, 2) = A(0, 0) * A(1, 1) - A(0, 1) * A(0, 1);
  return C;
}

/// A^T B where that is symmetric: the upper triangle is worked out and mirrored.
void setSymmetricProduct(const FitMatrix<3>& A, const FitMatrix<3>& B, Eigen::Matrix3d& product) {
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = i; j < 3; ++j) product(i, j) = product(j, i) = A.col(i).dot(B.col(j));
}

}  // namespace

FitGeometry::FitGeometry(const Vehicle& vehicle)
    : axle_x(vehicle.axleX(Axle::kFront), vehicle.axleX(Axle::kRear)),
      per_wheelbase(1.0 / vehicle.wheelbase),
      parallel_wheels(vehicle.axle_geometry == AxleGeometry::kPivot),
      hub_offset(vehicle.hub_offset.front != 0.0 || vehicle.hub_offset.rear != 0.0) {
  for (const Wheel wheel : kAllWheels) {
    const auto i = static_cast<Eigen::Index>(index(wheel));
    const Eigen::Vector2d pin = kingpin(vehicle, wheel);
    x(i) = pin.x();
    y(i) = pin.y();
    outward(i) = (isLeft(wheel) ? 1.0 : -1.0) * vehicle.hub_offset[axleOf(wheel)];
  }
}

namespace {

Eigen::Array4d perWheel(const Eigen::Array2d& axles) { return {axles(0), axles(0), axles(1), axles(1)}; }

}  // namespace

FitEquations fitEquations(const FitGeometry& geometry, const SteeringAngles& steering) {
  const Eigen::Array2d cosine(std::cos(steering.front), std::cos(steering.rear));
  const Eigen::Array2d sine(std::sin(steering.front), std::sin(steering.rear));
  // (K2) for vx = cos(phi_f) cos(phi_r), which needs no tangent; also the axles' travels, vx / cos(phi_j).
  FitEquations equations;
  equations.axle_ratio = cosine.reverse();
  const Eigen::Array2d& a = geometry.axle_x;
  const Eigen::Array2d across = sine * equations.axle_ratio * geometry.per_wheelbase;
  const double vx = cosine(0) * cosine(1);
  const double vy = a(0) * across(1) - a(1) * across(0);
  const double omega = across(0) - across(1);

  // (K3): the kingpin's velocity, and its direction without an angle in between; of its two senses that which
  // is nearer to the axle's.
  const Eigen::Array4d forward = vx - omega * geometry.y;
  const Eigen::Array4d sideways = vy + omega * geometry.x;
  equations.path_ratio = (forward.square() + sideways.square()).sqrt();
  const Eigen::Array4d along = forward * perWheel(cosine) + sideways * perWheel(sine);
  const Eigen::Array4d per_ratio = (along < 0.0).select(-1.0, Eigen::Array4d::Ones()) / equations.path_ratio;
  Eigen::Array4d cos_delta = forward * per_ratio;
  Eigen::Array4d sin_delta = sideways * per_ratio;
  if (geometry.parallel_wheels) {
    cos_delta = perWheel(cosine);
    sin_delta = perWheel(sine);
  }
  FitMatrix<3>& H = equations.H;
  H.col(0).head<4>() = cos_delta;
  H.col(1).head<4>() = sin_delta;
  H.col(2).head<4>() = geometry.x * sin_delta - geometry.y * cos_delta - geometry.outward;
  H.col(0).tail<2>() = -sine;
  H.col(1).tail<2>() = cosine;
  H.col(2).tail<2>() = a * cosine;
  return equations;
}

FitCovariance inverse(const FitCovariance& R) {
  const double scale = 1.0 / (R.axles(0) * R.axles(1) - R.shared * R.shared);
  return {R.wheels.inverse(), scale * R.axles.reverse(), -scale * R.shared};
}

FitSolution solveFit(const FitMatrix<3>& H, const FitCovariance& R, const Eigen::Vector4d& travels) {
  const FitCovariance weights = inverse(R);
  const FitMatrix<3> W = weights * H;
  Eigen::Matrix3d information;
  setSymmetricProduct(H, W, information);

  // The determinant is divided by last, so that the products before it need not wait.
  const Eigen::Matrix3d C = symmetricAdjugate(information);
  const double scale =
      1.0 / (information(0, 0) * C(0, 0) + information(0, 1) * C(0, 1) + information(0, 2) * C(0, 2));
  FitSolution fit;
  for (Eigen::Index i = 0; i < 3; ++i) {
    fit.Kt.col(i) = scale * (C(0, i) * W.col(0) + C(1, i) * W.col(1) + C(2, i) * W.col(2));
    fit.motion(i) = fit.Kt.col(i).head<4>().dot(travels);
    for (Eigen::Index j = 0; j < 3; ++j) fit.P(j, i) = scale * C(j, i);
  }
  fit.residual = -fit.motion(0) * H.col(0) - fit.motion(1) * H.col(1) - fit.motion(2) * H.col(2);
  fit.residual.head<4>() += travels;
  fit.chi_square = fit.residual.dot(weights * fit.residual);
  return fit;
}

FitMatrix<1> normalisedResiduals(const FitMatrix<3>& H, const FitCovariance& R, const FitSolution& solution) {
  const FitCovariance weights = inverse(R);
  const FitMatrix<3> W = weights * H;
  FitMatrix<1> M_diagonal;
  M_diagonal << weights.wheels, weights.axles;
  M_diagonal -= (W * solution.P).cwiseProduct(W).rowwise().sum();
  return (weights * solution.residual).array() / M_diagonal.array().sqrt();
}

WheelFit::WheelFit(const Vehicle& vehicle, const NoiseModel& noise)
    : vehicle_(vehicle),
      geometry_(vehicle),
      wheel_variance_(noise.wheel.variance()),
      lateral_variance_(noise.lateral.variance()),
      sensor_variance_(noise.steering.angle.variance() * noise.steering.correlation_length),
      law_variance_(noise.rear_law.variance() * noise.steering.correlation_length),
      per_correlation_length_(1.0 / noise.steering.correlation_length),
      wheels_used_(0),
      shared_sensor_(vehicle.rear_steering.source == RearSteering::Source::kPolynomial) {
  for (const Wheel wheel : kAllWheels) {
    const auto i = static_cast<Eigen::Index>(index(wheel));
    const double tick = vehicle.calibratedMetresPerTick(wheel);
    used_(i) = vehicle.hasEncoder(wheel) ? 1.0 : 0.0;
    rounding_(i) = vehicle.hasEncoder(wheel) ? tick * tick / 6.0 + kFloorVariance
                                             : std::numeric_limits<double>::infinity();
    per_gain_(i) = 1.0 / vehicle.wheelGain(wheel);
    half_track_(i) = 0.5 * vehicle.track[axleOf(wheel)];
    wheels_used_ += vehicle.hasEncoder(wheel) ? 1 : 0;
  }
}

/// y of (W1): S_i, and with a hub offset (H) the turn of the wheel's direction taken out of it.
Eigen::Array4d WheelFit::measuredTravels(const StepReadings& readings) const {
  Eigen::Array4d y = Eigen::Map<const Eigen::Array4d>(readings.travel.values.data()) * used_;
  if (!geometry_.hub_offset) return y;
  for (const Wheel wheel : kAllWheels) {
    const auto i = static_cast<Eigen::Index>(index(wheel));
    y(i) += used_(i) * geometry_.outward(i) *
            (wheelDirection(vehicle_, wheel, readings.end) - wheelDirection(vehicle_, wheel, readings.begin));
  }
  return y;
}

WheelFit::Believed WheelFit::believed(const StepReadings& readings) const {
  Believed believed{used_, rounding_};
  if (!readings.leavesOut()) return believed;
  for (Eigen::Index i = 0; i < believed.wheels.size(); ++i) {
    if (!readings.left_out.values[static_cast<std::size_t>(i)]) continue;
    believed.wheels(i) = 0.0;
    believed.rounding(i) = std::numeric_limits<double>::infinity();
  }
  return believed;
}

/// (W2): how far the car goes, for the path ratios of the equations.
double WheelFit::commonTravel(const FitEquations& equations, const StepReadings& readings,
                              const Believed& believed) const {
  const Eigen::Array4d readings_abs = Eigen::Map<const Eigen::Array4d>(readings.travel.values.data()).abs();
  return (readings_abs * believed.wheels).sum() / (equations.path_ratio * believed.wheels).sum();
}

/// R_0 of (W2): noise that adds up over the drive. `travel` is common to all: each wheel and each axle goes
/// so far times its ratio.
FitCovariance WheelFit::pathNoise(const FitEquations& equations, double travel, double rear_slope,
                                  const Believed& believed) const {
  const Eigen::Array2d V = travel * equations.axle_ratio;
  const Eigen::Array4d wheels = (wheel_variance_ * travel) * equations.path_ratio * believed.wheels;
  if (!shared_sensor_) return {wheels, (sensor_variance_ + lateral_variance_) * V, 0.0};
  // One reading, one error of variance sensor/V_front, which moves the axles by V_front and by f' V_rear.
  const double rear_over_front = equations.axle_ratio(1) / equations.axle_ratio(0);
  const Eigen::Array2d per_metre(
      sensor_variance_ + lateral_variance_,
      sensor_variance_ * rear_slope * rear_slope * rear_over_front + law_variance_ + lateral_variance_);
  return {wheels, per_metre * V, sensor_variance_ * rear_slope * V(1)};
}

/// What errors of the angles beyond their noise do to the axles' rows, (W3): the wheels then tell how the car
/// turns. Not part of the noise, since such an error outlasts the step (SteeringDoubt).
FitCovariance WheelFit::doubt(const FitEquations& equations, double travel, double rear_slope,
                              const PerAxle<double>& sigma) const {
  const Eigen::Array2d V = travel * equations.axle_ratio;
  if (!shared_sensor_)
    return {Eigen::Array4d::Zero(), (V * Eigen::Array2d(sigma.front, sigma.rear)).square(), 0.0};
  const Eigen::Array2d along = sigma.front * V * Eigen::Array2d(1.0, rear_slope);
  return {Eigen::Array4d::Zero(), along.square(), along(0) * along(1)};
}

/// R of (W2).
FitCovariance WheelFit::weighting(const Solved& solved, const StepReadings& readings) const {
  FitCovariance R{solved.path_noise.wheels + solved.believed.rounding,
                  solved.path_noise.axles + kFloorVariance, solved.path_noise.shared};
  if (!readings.isDoubted()) return R;
  const FitCovariance doubted =
      doubt(solved.equations, solved.travel, solved.rear_slope, readings.steering_doubt);
  R.axles += doubted.axles;
  R.shared += doubted.shared;
  return R;
}

WheelFit::Solved WheelFit::solve(const StepReadings& readings) const {
  const SteeringAngles angles = readings.mean();
  Solved solved{};
  solved.rear_slope = shared_sensor_ ? vehicle_.rear_steering.slope(angles.front) : 0.0;
  solved.believed = believed(readings);
  solved.equations = fitEquations(geometry_, angles);
  solved.travel = commonTravel(solved.equations, readings, solved.believed);
  solved.path_noise = pathNoise(solved.equations, solved.travel, solved.rear_slope, solved.believed);
  solved.R = weighting(solved, readings);
  solved.fit = solveFit(solved.equations.H, solved.R, measuredTravels(readings));
  return solved;
}

/// One piece of code (flatten): its parts pass more between them than fits in registers.
[[gnu::flatten]] void WheelFit::update(const StepReadings& readings, BodyIncrement& increment) const {
  const Solved solved = solve(readings);
  const FitSolution& fit = solved.fit;
  setSymmetricProduct(fit.Kt, solved.path_noise * fit.Kt, increment.path_covariance);
  setSensitivity(solved.equations.H, fit, readings, solved.rear_slope, increment.J_motion_systematic);
  setResiduals(solved, readings, increment.residuals);
  increment.motion = fit.motion;
  setStepCovariance(solved, readings, increment.step_covariance);
}

/// P, but for what the doubt of the angles has added to its weights.
void WheelFit::setStepCovariance(const Solved& solved, const StepReadings& readings,
                                 Eigen::Matrix3d& step_covariance) const {
  step_covariance = solved.fit.P;
  if (readings.isDoubted()) {
    const FitCovariance doubted =
        doubt(solved.equations, solved.travel, solved.rear_slope, readings.steering_doubt);
    step_covariance -= solved.fit.Kt.transpose() * (doubted * solved.fit.Kt);
  }
  subtractSteeringOfOtherSteps(solved.fit, solved.equations.axle_ratio * solved.travel, solved.path_noise,
                               step_covariance);
}

/// R has the errors of the angles as if fresh in each step, so that they add up as they should; a shorter
/// step than their correlation length has no more of them than itself: d/l of it. What R_0 has beyond the
/// side slip is theirs.
void WheelFit::subtractSteeringOfOtherSteps(const FitSolution& fit, const Eigen::Array2d& V,
                                            const FitCovariance& path_noise,
                                            Eigen::Matrix3d& step_covariance) const {
  const double excess = 1.0 - V(0) * per_correlation_length_;
  if (excess <= 0.0) return;
  const Eigen::Array2d S = excess * (path_noise.axles - lateral_variance_ * V);
  const double shared = excess * path_noise.shared;
  const auto K = fit.Kt.bottomRows<2>();
  for (Eigen::Index j = 0; j < 3; ++j) {
    const double front = S(0) * K(0, j) + shared * K(1, j);
    const double rear = shared * K(0, j) + S(1) * K(1, j);
    for (Eigen::Index i = 0; i <= j; ++i) {
      step_covariance(i, j) -= K(0, i) * front + K(1, i) * rear;
      step_covariance(j, i) = step_covariance(i, j);
    }
  }
}

/// One piece of code like update(): worth a quarter of its instructions.
[[gnu::flatten]] BodyMotion WheelFit::motion(const StepReadings& readings) const {
  return solve(readings).fit.motion;
}

StepNoise WheelFit::noiseSources(const StepReadings& readings) const {
  const Solved solved = solve(readings);
  const FitEquations& equations = solved.equations;
  StepNoise noise;
  noise.J_motion_wheel = solved.fit.Kt.topRows<4>().transpose();
  Eigen::Map<Eigen::Array4d>(noise.wheel_path.values.data()) =
      solved.travel * equations.path_ratio * solved.believed.wheels;
  noise.J_motion_slip = solved.fit.Kt.bottomRows<2>().transpose();
  noise.axle_path = {solved.travel * equations.axle_ratio(0), solved.travel * equations.axle_ratio(1)};
  return noise;
}

/// D = dy/dA - dH/dA t, at the fitted travels: the measured ones err together with the residuals that D is
/// multiplied by, which would make every gain too small by c^2 over the length of a step (0.1 % at 25 mm).
FitMatrix<systematic::kCount> WheelFit::J_equations(const Solved& solved,
                                                    const StepReadings& readings) const {
  using namespace systematic;
  const FitMatrix<3>& H = solved.equations.H;
  const BodyMotion& t = solved.fit.motion;
  const Eigen::Map<const Eigen::Array4d> travels(readings.travel.values.data());
  const Eigen::Array4d nominal = (travels - solved.fit.residual.head<4>().array()) * used_ * per_gain_;
  const Eigen::Array4d half_turn = t.z() * half_track_ * H.col(0).head<4>().array();
  const SteeringEffect steering = steeringEffect(H, t);
  FitMatrix<kCount> D = FitMatrix<kCount>::Zero();
  D(0, kFrontLeft) = nominal(0);
  D(1, kFrontRight) = nominal(1);
  D(2, kRearLeft) = nominal(2);
  D(3, kRearRight) = nominal(3);
  D.col(kFrontTrack).segment<2>(0) << half_turn(0), -half_turn(1);
  D.col(kRearTrack).segment<2>(2) << half_turn(2), -half_turn(3);
  D.col(kFrontOffset).segment<2>(0) = -steering.across.head<2>();
  D(4, kFrontOffset) = steering.along(0);
  const Eigen::Index rear = shared_sensor_ ? kFrontOffset : kRearOffset;
  const double slope = shared_sensor_ ? solved.rear_slope : 1.0;
  D.col(rear).segment<2>(2) = -slope * steering.across.tail<2>();
  D(5, rear) = slope * steering.along(1);
  return D;
}

ParameterEvidence WheelFit::evidence(const StepReadings& readings) const {
  const Solved solved = solve(readings);
  const FitMatrix<systematic::kCount> D = J_equations(solved, readings);
  const FitCovariance weights = inverse(solved.R);
  const FitMatrix<systematic::kCount> WD = weights * D;
  const Eigen::Matrix<double, 3, systematic::kCount> HWD = solved.equations.H.transpose() * WD;
  ParameterEvidence evidence;
  evidence.information = D.transpose() * WD - HWD.transpose() * solved.fit.P * HWD;
  evidence.gradient = -WD.transpose() * solved.fit.residual;
  evidence.chi_square = solved.fit.chi_square;
  return evidence;
}

void WheelFit::setResiduals(const Solved& solved, const StepReadings& readings,
                            FitResiduals& residuals) const {
  const FitSolution& fit = solved.fit;
  Eigen::Map<Eigen::Array4d>(residuals.wheel.values.data()) = fit.residual.head<4>().array() * used_;
  residuals.axle = {fit.residual(4), fit.residual(5)};
  residuals.chi_square = fit.chi_square;
  residuals.degrees_of_freedom = wheels_used_ - 1;  // and two axles, less three unknowns
  if (readings.leavesOut()) residuals.degrees_of_freedom = static_cast<int>(solved.believed.wheels.sum()) - 1;
  for (const double doubt : {readings.steering_doubt.front, readings.steering_doubt.rear})
    if (doubt > 0.0) --residuals.degrees_of_freedom;
  residuals.degrees_of_freedom = std::max(residuals.degrees_of_freedom, 0);
}

/// An axle's row moves by the travel V_j along its angle; a wheel's row by the sideways travel of the wheel,
/// which is zero where it rolls freely (Ackermann) and not where both wheels of an axle are kept parallel.
WheelFit::SteeringEffect WheelFit::steeringEffect(const FitMatrix<3>& H, const BodyMotion& t) const {
  SteeringEffect effect;
  effect.along =
      H.col(1).tail<2>().array() * t.x() - H.col(0).tail<2>().array() * (t.y() + geometry_.axle_x * t.z());
  if (geometry_.parallel_wheels) {
    effect.across = H.col(0).head<4>().array() * (t.y() + geometry_.x * t.z()) -
                    H.col(1).head<4>().array() * (t.x() - geometry_.y * t.z());
  } else {
    effect.across.setZero();
  }
  return effect;
}

/// Derivatives of the motion, transposed, with respect to the two axles' angles.
Eigen::Matrix<double, 2, 3> WheelFit::J_motion_steering(const FitMatrix<3>& H, const FitSolution& fit) const {
  const SteeringEffect effect = steeringEffect(H, fit.motion);
  Eigen::Matrix<double, 2, 3> J = fit.Kt.bottomRows<2>().array().colwise() * effect.along;
  if (geometry_.parallel_wheels) {
    J.row(0) -= effect.across.head<2>().matrix().transpose() * fit.Kt.middleRows<2>(0);
    J.row(1) -= effect.across.tail<2>().matrix().transpose() * fit.Kt.middleRows<2>(2);
  }
  return J;
}

/// dt/dA = K (dy/dA - dH/dA t) (docs/model.md, section 6).
void WheelFit::setSensitivity(const FitMatrix<3>& H, const FitSolution& fit, const StepReadings& readings,
                              double rear_slope, SystematicSensitivity& J) const {
  using namespace systematic;
  const Eigen::Array4d nominal = Eigen::Map<const Eigen::Array4d>(readings.travel.values.data()) * per_gain_;
  // A wider track moves both wheels out, y_i by +/- B/2, and so row i of H by -/+ B/2 cos(delta_i).
  const Eigen::Array4d half_turn = fit.motion.z() * half_track_ * H.col(0).head<4>().array();
  const Eigen::Matrix<double, 2, 3> J_steering = J_motion_steering(H, fit);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto K = fit.Kt.col(i).head<4>().array();
    const Eigen::Array4d gain = K * nominal;
    const Eigen::Array4d track = K * half_turn;
    J(i, kFrontRight) = gain(1);
    J(i, kFrontLeft) = gain(0);
    J(i, kFrontTrack) = track(0) - track(1);
    J(i, kFrontOffset) = J_steering(0, i) + rear_slope * J_steering(1, i);
    J(i, kRearRight) = gain(3);
    J(i, kRearLeft) = gain(2);
    J(i, kRearTrack) = track(2) - track(3);
    J(i, kRearOffset) = shared_sensor_ ? 0.0 : J_steering(1, i);
  }
}

}  // namespace bs_car_odometry
