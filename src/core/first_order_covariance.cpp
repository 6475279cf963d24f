#include "bs_car_odometry/core/first_order_covariance.hpp"

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

void setTotal(const Eigen::Matrix3d& noise, const SystematicSensitivity& J, double scale,
              Eigen::Matrix3d& total) {
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = i; j < 3; ++j)
      total(i, j) = total(j, i) = scale * (noise(i, j) + J.row(i).dot(J.row(j)));
}

void FirstOrderCovariance::reset(const Eigen::Matrix3d& initial) {
  noise_ = 0.5 * (initial + initial.transpose());
  sensitivity_.setZero();
}

void FirstOrderCovariance::advance(const PoseStep& step, const Eigen::Matrix3d& path_covariance,
                                   const SystematicSensitivity& J_motion) {
  addNoise(step, path_covariance);
  const SystematicSensitivity& J = J_motion;  // F Phi + G J row by row
  sensitivity_.row(0) +=
      step.r * J.row(0) - step.s * J.row(1) + step.p * J.row(2) - step.dy * sensitivity_.row(2);
  sensitivity_.row(1) +=
      step.s * J.row(0) + step.r * J.row(1) + step.q * J.row(2) + step.dx * sensitivity_.row(2);
  sensitivity_.row(2) += J.row(2);
}

/// F Sigma F^T + G P G^T, upper triangle first. With F = I + f e3^T, f = (-dy, dx, 0), what F adds to Sigma
/// needs only the heading's column: f h^T + h f^T, h = Sigma e3 + Var(theta) f/2.
void FirstOrderCovariance::addNoise(const PoseStep& step, const Eigen::Matrix3d& P) {
  const Eigen::RowVector3d GP_x = step.r * P.row(0) - step.s * P.row(1) + step.p * P.row(2);
  const Eigen::RowVector3d GP_y = step.s * P.row(0) + step.r * P.row(1) + step.q * P.row(2);
  const double yaw_variance = noise_(2, 2);
  const double h_x = noise_(0, 2) - 0.5 * yaw_variance * step.dy;
  const double h_y = noise_(1, 2) + 0.5 * yaw_variance * step.dx;

  noise_(0, 0) += step.r * GP_x.x() - step.s * GP_x.y() + step.p * GP_x.z() - 2.0 * step.dy * h_x;
  noise_(0, 1) += step.s * GP_x.x() + step.r * GP_x.y() + step.q * GP_x.z() + step.dx * h_x - step.dy * h_y;
  noise_(1, 1) += step.s * GP_y.x() + step.r * GP_y.y() + step.q * GP_y.z() + 2.0 * step.dx * h_y;
  noise_(0, 2) += GP_x.z() - step.dy * yaw_variance;
  noise_(1, 2) += GP_y.z() + step.dx * yaw_variance;
  noise_(2, 2) += P(2, 2);
  noise_(1, 0) = noise_(0, 1);
  noise_(2, 0) = noise_(0, 2);
  noise_(2, 1) = noise_(1, 2);
}

SystematicCovariance systematicCovariance(const SystematicNoise& noise) {
  Eigen::Matrix<double, systematic::kCount, 1> sigma;
  sigma << noise.k_r, noise.k_l, noise.k_b, noise.steering_offset,  //
      noise.k_r, noise.k_l, noise.k_b, noise.steering_offset;
  return sigma.array().square().matrix().asDiagonal();
}

}  // namespace bs_car_odometry
