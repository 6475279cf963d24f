#include "chain_filter.hpp"

#include "bs_car_odometry/calibration/planar.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <cmath>

namespace bs_car_odometry::calibration {

ParameterPrior::ParameterPrior(const Parameters& parameters)
    : estimated(parametersToEstimate(parameters)),
      mean(valuesOf(parameters)),
      deviation(priorDeviations(parameters)) {
  for (std::size_t i = 0; i < kCount; ++i)
    if (estimated[i]) active.push_back(static_cast<Eigen::Index>(i));
}

ChainFilter::ChainFilter(const ParameterPrior& prior, const ParameterVector& values)
    : prior_(prior),
      values_(values),
      n_(3 + static_cast<Eigen::Index>(prior.active.size())),
      x_(StateVector::Zero(n_)),
      P_(StateMatrix::Zero(n_, n_)) {
  for (Eigen::Index k = 3; k < n_; ++k) {
    const Eigen::Index i = prior.active[static_cast<std::size_t>(k - 3)];
    x_[k] = prior.mean[i] - values[i];
    P_(k, k) = std::pow(prior.deviation[i], 2);
  }
}

void ChainFilter::add(const Chain& chain, const NoiseScales& scales,
                      std::vector<ChainInnovation>* innovations) {
  takeEvidence(chain.evidence);
  bool known = false;
  for (std::size_t i = 0; i < chain.nodes.size(); ++i) {
    const Node& node = chain.nodes[i];
    known = known && node.linked;
    if (known) move(chain.nodes[i - 1], node, scales.wheel);
    if (node.weight == 0.0) continue;
    const Eigen::Matrix3d R = scaled(node.covariance, scales.laser) / node.weight;
    if (known) {
      const ChainInnovation innovation = correct(node, R);
      if (innovations) innovations->push_back(innovation);
    } else {
      begin(node, R);
      known = true;
    }
  }
}

/// P^-1 grows by the information, without an inverse: most drives leave some of it singular.
void ChainFilter::takeEvidence(const Evidence& evidence) {
  const Eigen::Index n = n_ - 3;
  StateMatrix information = StateMatrix::Zero(n, n);
  StateVector gradient = StateVector::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index i = prior_.active[static_cast<std::size_t>(k)];
    if (i >= static_cast<Eigen::Index>(kMotionCount)) continue;
    gradient[k] = evidence.gradient[i];
    for (Eigen::Index l = 0; l < n; ++l) {
      const Eigen::Index j = prior_.active[static_cast<std::size_t>(l)];
      if (j < static_cast<Eigen::Index>(kMotionCount)) information(k, l) = evidence.information(i, j);
    }
  }
  gradient -= information * x_.tail(n);
  const StateMatrix M = StateMatrix::Identity(n, n) + information * P_.bottomRightCorner(n, n);
  const StateMatrix gained = M.partialPivLu().solve(information * P_.bottomRows(n));
  P_ -= (P_.rightCols(n) * gained).eval();
  P_ = 0.5 * (P_ + P_.transpose().eval());
  x_ += P_.rightCols(n) * gradient;
}

/// [F, R J]: error of the pose after a link, by the errors of the pose before it and of the parameters.
ChainFilter::Rows ChainFilter::motionJacobian(const Node& from, const Node& to) const {
  Rows T = Rows::Zero(3, n_);
  T.leftCols<3>() = leverArm(to.pose.head<2>() - from.pose.head<2>());
  const MotionSensitivity J = rotation(from.pose.z()) * to.link.J;
  for (Eigen::Index k = 3; k < n_; ++k) {
    const Eigen::Index i = prior_.active[static_cast<std::size_t>(k - 3)];
    if (i < static_cast<Eigen::Index>(kMotionCount)) T.col(k) = J.col(i);
  }
  return T;
}

void ChainFilter::move(const Node& from, const Node& to, double wheel_scale) {
  const Eigen::Matrix3d R = rotation(from.pose.z());
  const Rows T = motionJacobian(from, to);
  const Rows TP = T * P_;
  const Eigen::Matrix3d noise =
      (to.link.noise + (wheel_scale * wheel_scale - 1.0) * to.link.wheels) / to.link.weight;
  x_.head<3>() = (T * x_ - R * motionResidual(from, to)).eval();
  P_.topLeftCorner<3, 3>() = TP * T.transpose() + R * noise * R.transpose();
  P_.topRightCorner(3, n_ - 3) = TP.rightCols(n_ - 3);
  P_.bottomLeftCorner(n_ - 3, 3) = TP.rightCols(n_ - 3).transpose();
}

/// Of the laser's pose, by the errors of base_link's pose and of the parameters.
ChainFilter::Rows ChainFilter::laserJacobian(const Node& node) const {
  const Eigen::Matrix3d R = rotation(node.pose.z());
  const Eigen::Vector3d arm = R * Eigen::Vector3d(values_[kLaserX], values_[kLaserY], 0.0);
  const BodyMotion& v = node.twist;
  Rows H = Rows::Zero(3, n_);
  H.leftCols<3>() = leverArm(arm.head<2>());
  for (Eigen::Index k = 3; k < n_; ++k) {
    const Eigen::Index i = prior_.active[static_cast<std::size_t>(k - 3)];
    if (i >= static_cast<Eigen::Index>(kLaserX) && i <= static_cast<Eigen::Index>(kLaserYaw))
      H.col(k) = R.col(i - static_cast<Eigen::Index>(kLaserX));
    if (i == static_cast<Eigen::Index>(kTimeOffset))
      H.col(k) = -(R * v + v.z() * Eigen::Vector3d(-arm.y(), arm.x(), 0.0));
  }
  return H;
}

/// A pose that nothing is known of is what the laser says, tied to the parameters as the laser is.
void ChainFilter::begin(const Node& node, const Eigen::Matrix3d& R) {
  const Rows H = laserJacobian(node);
  const Eigen::Matrix3d inverse = H.leftCols<3>().inverse();
  const auto parameters = H.rightCols(n_ - 3);
  const Rows cross = -inverse * parameters * P_.bottomRightCorner(n_ - 3, n_ - 3);
  x_.head<3>() = inverse * (laserResidual(node, values_) - parameters * x_.tail(n_ - 3));
  P_.topLeftCorner<3, 3>() = inverse * R * inverse.transpose() - cross * (inverse * parameters).transpose();
  P_.topRightCorner(3, n_ - 3) = cross;
  P_.bottomLeftCorner(n_ - 3, 3) = cross.transpose();
}

ChainInnovation ChainFilter::correct(const Node& node, const Eigen::Matrix3d& R) {
  const Rows H = laserJacobian(node);
  const Rows HP = H * P_;
  ChainInnovation innovation{laserResidual(node, values_) - H * x_, HP * H.transpose() + R};
  const Rows SHP = innovation.covariance.llt().solve(HP);
  x_ += SHP.transpose() * innovation.residual;
  P_ -= HP.transpose() * SHP;
  P_ = 0.5 * (P_ + P_.transpose().eval());
  return innovation;
}

ParameterVector ChainFilter::correction() const {
  ParameterVector correction = ParameterVector::Zero();
  for (Eigen::Index k = 3; k < n_; ++k) correction[prior_.active[static_cast<std::size_t>(k - 3)]] = x_[k];
  return correction;
}

ParameterMatrix ChainFilter::covariance() const {
  ParameterMatrix covariance = ParameterMatrix::Zero();
  for (Eigen::Index k = 3; k < n_; ++k)
    for (Eigen::Index l = 3; l < n_; ++l)
      covariance(prior_.active[static_cast<std::size_t>(k - 3)],
                 prior_.active[static_cast<std::size_t>(l - 3)]) = P_(k, l);
  return covariance;
}

}  // namespace bs_car_odometry::calibration
