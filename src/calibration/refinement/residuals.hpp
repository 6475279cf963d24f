#pragma once

#include "chain.hpp"
#include "chain_filter.hpp"

#include <ceres/loss_function.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <cmath>

namespace bs_car_odometry::calibration {

/// The parameters as the solver sees them: two blocks, so that a residual has only those that it depends on.
constexpr int kMotionBlock = static_cast<int>(kMotionCount);
constexpr int kLaserBlock = static_cast<int>(kCount) - kMotionBlock;

/// L^-1 of A = L L^T, whitens an error of covariance A.
inline Eigen::Matrix3d whitening(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d L = covariance.llt().matrixL();
  return L.triangularView<Eigen::Lower>().solve(Eigen::Matrix3d::Identity());
}

/// W (e) for residuals of any scalar.
template <typename T>
void whiten(const Eigen::Matrix3d& W, const T* e, T* residual) {
  residual[0] = W(0, 0) * e[0];
  residual[1] = W(1, 0) * e[0] + W(1, 1) * e[1];
  residual[2] = W(2, 0) * e[0] + W(2, 1) * e[1] + W(2, 2) * e[2];
}

/// (C21): the motion between two poses against that of the readings.
class MotionResidual {
 public:
  /// @param values  that the link was worked out with
  MotionResidual(const Link& link, const ParameterVector& values, const ParameterMask& estimated)
      : motion_(link.motion.vector()),
        J_(link.J),
        values_(values.head<kMotionBlock>()),
        W_(whitening(link.noise)) {
    for (int i = 0; i < kMotionBlock; ++i)
      if (!estimated[static_cast<std::size_t>(i)]) J_.col(i).setZero();
  }

  template <typename T>
  bool operator()(const T* from, const T* to, const T* values, T* residual) const {
    using std::cos;
    using std::sin;
    const T c = cos(from[2]);
    const T s = sin(from[2]);
    const T dx = to[0] - from[0];
    const T dy = to[1] - from[1];
    T e[3] = {c * dx + s * dy - motion_[0], c * dy - s * dx - motion_[1], to[2] - from[2] - motion_[2]};
    for (int i = 0; i < kMotionBlock; ++i) {
      const T change = values[i] - values_[i];
      for (int j = 0; j < 3; ++j) e[j] -= J_(j, i) * change;
    }
    whiten(W_, e, residual);
    return true;
  }

 private:
  Eigen::Vector3d motion_;
  MotionSensitivity J_;
  Eigen::Matrix<double, kMotionBlock, 1> values_;
  Eigen::Matrix3d W_;
};

/// (C22): where the laser measured against where it was, linear in how much later than the node.
class LaserPoseResidual {
 public:
  LaserPoseResidual(const Node& node, const ParameterVector& values, const ParameterMask& estimated)
      : measured_(node.measured),
        twist_(node.twist),
        values_(values.tail<kLaserBlock>()),
        W_(whitening(node.covariance)) {
    for (int i = 0; i < kLaserBlock; ++i)
      estimated_[i] = estimated[static_cast<std::size_t>(kMotionBlock + i)] ? 1.0 : 0.0;
  }

  template <typename T>
  bool operator()(const T* pose, const T* values, T* residual) const {
    using std::cos;
    using std::sin;
    T laser[kLaserBlock];  // x, y, yaw, time offset
    for (int i = 0; i < kLaserBlock; ++i) laser[i] = values_[i] + estimated_[i] * (values[i] - values_[i]);
    const T late = values_[3] - laser[3];
    const T c = cos(pose[2]);
    const T s = sin(pose[2]);
    const T x = laser[0] + late * (twist_[0] - twist_[2] * laser[1]);
    const T y = laser[1] + late * (twist_[1] + twist_[2] * laser[0]);
    const T e[3] = {measured_[0] - pose[0] - (c * x - s * y), measured_[1] - pose[1] - (s * x + c * y),
                    measured_[2] - pose[2] - laser[2] - late * twist_[2]};
    whiten(W_, e, residual);
    return true;
  }

 private:
  Eigen::Vector3d measured_;
  BodyMotion twist_;
  Eigen::Vector4d values_;
  Eigen::Vector4d estimated_;
  Eigen::Matrix3d W_;
};

/// What the wheels say among each other, L = V diag(l) V^T of (C13) and the gradient g about some values:
/// r_k = sqrt(l_k) v_k^T (p - p_0) - v_k^T g / sqrt(l_k), where there is any information.
class EvidenceResidual {
 public:
  EvidenceResidual(const Evidence& evidence, const ParameterVector& values, const ParameterMask& estimated)
      : values_(values.head<kMotionBlock>()) {
    Eigen::Matrix<double, kMotionBlock, 1> mask;
    for (int i = 0; i < kMotionBlock; ++i) mask[i] = estimated[static_cast<std::size_t>(i)] ? 1.0 : 0.0;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kMotionBlock, kMotionBlock>> solver(
        mask.asDiagonal() * evidence.information * mask.asDiagonal());
    const auto& l = solver.eigenvalues();
    for (int k = 0; k < kMotionBlock; ++k) {
      const bool any = l[k] > 1e-12 * l[kMotionBlock - 1];  // the rest is rounding
      root_.row(k) = (any ? std::sqrt(l[k]) : 0.0) * solver.eigenvectors().col(k).transpose();
      const double g = solver.eigenvectors().col(k).dot(mask.cwiseProduct(evidence.gradient));
      offset_[k] = any ? g / std::sqrt(l[k]) : 0.0;
    }
  }

  template <typename T>
  bool operator()(const T* values, T* residual) const {
    for (int k = 0; k < kMotionBlock; ++k) {
      residual[k] = T(-offset_[k]);
      for (int i = 0; i < kMotionBlock; ++i) residual[k] += root_(k, i) * (values[i] - values_[i]);
    }
    return true;
  }

 private:
  Eigen::Matrix<double, kMotionBlock, 1> values_;
  Eigen::Matrix<double, kMotionBlock, kMotionBlock> root_;
  Eigen::Matrix<double, kMotionBlock, 1> offset_;
};

/// What is believed of the parameters before the drives. Those that are not estimated have no other residual
/// than this, so they stay where they are.
template <int Begin, int Count>
class PriorResidual {
 public:
  explicit PriorResidual(const ParameterPrior& prior) : mean_(prior.mean.segment<Count>(Begin)) {
    for (int i = 0; i < Count; ++i)
      weight_[i] = prior.deviation[Begin + i] > 0.0 ? 1.0 / prior.deviation[Begin + i] : 1.0;
  }

  template <typename T>
  bool operator()(const T* values, T* residual) const {
    for (int i = 0; i < Count; ++i) residual[i] = weight_[i] * (values[i] - mean_[i]);
    return true;
  }

 private:
  Eigen::Matrix<double, Count, 1> mean_;
  Eigen::Matrix<double, Count, 1> weight_;
};

/// (C24) rho(s) = s up to the limit, then limit (1 + log(s / limit)): its slope is the weight that the filter
/// gives to a laser pose, min(1, limit / s).
class SoftWeightLoss final : public ceres::LossFunction {
 public:
  static double weight(double square) { return square > kSoftLimit ? kSoftLimit / square : 1.0; }

  void Evaluate(double square, double* rho) const override {
    const bool beyond = square > kSoftLimit;
    rho[0] = beyond ? kSoftLimit * (1.0 + std::log(square / kSoftLimit)) : square;
    rho[1] = weight(square);
    rho[2] = beyond ? -rho[1] / square : 0.0;
  }
};

/// rho(s) = s up to the limit, then limit (2 - limit / s): a wheel that spins is wrong by so much that its
/// motion must count for nothing, where laser poses that are a little too far off still count.
class SlipLoss final : public ceres::LossFunction {
 public:
  static double weight(double square) {
    return square > kSoftLimit ? kSoftLimit * kSoftLimit / (square * square) : 1.0;
  }

  void Evaluate(double square, double* rho) const override {
    const bool beyond = square > kSoftLimit;
    rho[0] = beyond ? kSoftLimit * (2.0 - kSoftLimit / square) : square;
    rho[1] = weight(square);
    rho[2] = beyond ? -2.0 * rho[1] / square : 0.0;
  }
};

}  // namespace bs_car_odometry::calibration
