#include "bs_car_odometry/core/systematic_prior.hpp"

#include <Eigen/SVD>

#include <cmath>

namespace bs_car_odometry {

namespace {

/// L with L L^T = A, also where A is singular.
SystematicCovariance lowerRoot(const SystematicCovariance& A) {
  SystematicCovariance L = SystematicCovariance::Zero();
  for (Eigen::Index j = 0; j < L.cols(); ++j) {
    const double pivot = A(j, j) - L.row(j).head(j).squaredNorm();
    if (pivot <= A(j, j) * 1e-14) continue;  // follows from the parameters before it
    L(j, j) = std::sqrt(pivot);
    for (Eigen::Index i = j + 1; i < L.rows(); ++i)
      L(i, j) = (A(i, j) - L.row(i).head(j).dot(L.row(j).head(j))) / L(j, j);
  }
  return L;
}

}  // namespace

SystematicRoot::SystematicRoot(const SystematicCovariance& covariance) {
  const SystematicCovariance L = lowerRoot(covariance);
  front_ = L.topLeftCorner<4, 4>();
  rear_front_ = L.bottomLeftCorner<4, 4>();
  rear_ = L.bottomRightCorner<4, 4>();
}

SystematicSensitivity SystematicRoot::operator()(const SystematicSensitivity& J) const {
  SystematicSensitivity product;
  product.leftCols<4>() = J.leftCols<4>().lazyProduct(front_) + J.rightCols<4>().lazyProduct(rear_front_);
  product.rightCols<4>() = J.rightCols<4>().lazyProduct(rear_);
  return product;
}

SystematicCovariance SystematicRoot::matrix() const {
  SystematicCovariance L = SystematicCovariance::Zero();
  L.topLeftCorner<4, 4>() = front_;
  L.bottomLeftCorner<4, 4>() = rear_front_;
  L.bottomRightCorner<4, 4>() = rear_;
  return L;
}

SystematicCovariance SystematicRoot::inverse() const {
  constexpr int kBothBases = Eigen::ComputeFullU | Eigen::ComputeFullV;
  return Eigen::JacobiSVD<SystematicCovariance>(matrix(), kBothBases).solve(SystematicCovariance::Identity());
}

namespace {

using Parameters = std::array<bool, systematic::kCount>;

/// Parameters that the odometry of this configuration has anything to do with.
Parameters parametersUsed(const OdometryConfiguration& c) {
  using namespace systematic;
  const PerWheel<bool> wheels = wheelsUsed(c.vehicle, c.options);
  const bool slaved = c.vehicle.rear_steering.source == RearSteering::Source::kPolynomial;
  Parameters used;
  used[kFrontRight] = wheels[Wheel::kFrontRight];
  used[kFrontLeft] = wheels[Wheel::kFrontLeft];
  used[kFrontTrack] = used[kFrontRight] || used[kFrontLeft];
  used[kRearRight] = wheels[Wheel::kRearRight];
  used[kRearLeft] = wheels[Wheel::kRearLeft];
  used[kRearTrack] = used[kRearRight] || used[kRearLeft];
  used[kFrontOffset] = c.options.axles != AxleSelection::kRear || slaved;
  used[kRearOffset] = c.options.axles != AxleSelection::kFront && !slaved;
  return used;
}

/// A component of a matters when it reaches a parameter that does.
Parameters componentsActive(const SystematicRoot& root, const OdometryConfiguration& configuration) {
  const SystematicCovariance L = root.matrix();
  const Parameters used = parametersUsed(configuration);
  Parameters active{};
  for (std::size_t j = 0; j < active.size(); ++j)
    for (std::size_t i = j; i < used.size(); ++i)
      active[j] =
          active[j] || (used[i] && L(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) != 0.0);
  return active;
}

}  // namespace

SystematicPrior::SystematicPrior(const OdometryConfiguration& configuration)
    : SystematicPrior(systematicCovariance(configuration), configuration) {}

SystematicPrior::SystematicPrior(const SystematicCovariance& covariance,
                                 const OdometryConfiguration& configuration)
    : root(covariance), active(componentsActive(root, configuration)) {
  const SystematicNoise& noise = configuration.noise.systematic;
  const SystematicCovariance nominal = systematicCovariance(noise);
  shape = {noise.k_r, noise.k_l, noise.k_b, noise.steering_offset,
           noise.k_r, noise.k_l, noise.k_b, noise.steering_offset};
  for (Eigen::Index j = 0; j < covariance.cols(); ++j)
    if (covariance.col(j) != nominal.col(j)) shape[static_cast<std::size_t>(j)] = Distribution(1.0);
}

void setTotal(const Eigen::Matrix3d& noise, const SystematicSensitivity& J, double scale,
              Eigen::Matrix3d& total) {
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = i; j < 3; ++j)
      total(i, j) = total(j, i) = scale * (noise(i, j) + J.row(i).dot(J.row(j)));
}

SystematicCovariance systematicCovariance(const SystematicNoise& noise) {
  Eigen::Matrix<double, systematic::kCount, 1> sigma;
  sigma << noise.k_r.std(), noise.k_l.std(), noise.k_b.std(), noise.steering_offset.std(),  //
      noise.k_r.std(), noise.k_l.std(), noise.k_b.std(), noise.steering_offset.std();
  return sigma.array().square().matrix().asDiagonal();
}

SystematicCovariance systematicCovariance(const OdometryConfiguration& configuration) {
  return configuration.systematic_covariance.value_or(systematicCovariance(configuration.noise.systematic));
}

SystematicCovariance carriedOver(const SystematicRoot& before, const SystematicRoot& after) {
  constexpr int kBothBases = Eigen::ComputeFullU | Eigen::ComputeFullV;
  const SystematicCovariance M = before.inverse() * after.matrix();
  const Eigen::JacobiSVD<SystematicCovariance> svd(M, kBothBases);
  const auto share = svd.singularValues().unaryExpr([](double s) { return s > 1.0 ? 1.0 / s : s; });
  return svd.matrixU() * share.asDiagonal() * svd.matrixV().transpose();
}

Eigen::Matrix3d carryOver(const SystematicCovariance& M, SystematicSensitivity& sensitivity) {
  const Eigen::Matrix3d before = sensitivity * sensitivity.transpose();
  sensitivity = (sensitivity * M).eval();
  return before - sensitivity * sensitivity.transpose();
}

}  // namespace bs_car_odometry
