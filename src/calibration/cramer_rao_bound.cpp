#include "bs_car_odometry/calibration/cramer_rao_bound.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

namespace bs_car_odometry::calibration {

namespace {

/// Upper triangular T with T^T T = M^T M.
Eigen::MatrixXd triangular(const Eigen::MatrixXd& M) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(M);
  return qr.matrixQR().topRows(M.cols()).triangularView<Eigen::Upper>();
}

/// L with L L^T = Q, also where Q is singular.
Eigen::MatrixXd rootOf(const Eigen::MatrixXd& Q) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(Q);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

}  // namespace

CramerRaoBound::CramerRaoBound(const Eigen::VectorXd& prior)
    : root_(Eigen::MatrixXd::Zero(3 + prior.size(), 3 + prior.size())) {
  root_.diagonal().head<3>().setConstant(1.0 / kDiffuse);
  root_.diagonal().tail(prior.size()) = prior.cwiseInverse();
}

/// W (pose, parameters) = noise of unit variance is what is known before. In it pose = F^-1 (pose' - J
/// parameters - L e) with e of unit variance; the rows that the triangle leaves without e hold what is known
/// after.
void CramerRaoBound::predict(const Eigen::Matrix3d& F, const PoseSensitivity& J, const Eigen::Matrix3d& Q) {
  const Eigen::Index n = root_.cols();
  const Eigen::MatrixXd of_pose = root_.leftCols<3>() * F.inverse();
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n + 3, n + 3);
  M.topLeftCorner<3, 3>().setIdentity();
  M.bottomLeftCorner(n, 3) = -of_pose * rootOf(Q);
  M.block(3, 3, n, 3) = of_pose;
  M.bottomRightCorner(n, parameters()) = root_.rightCols(parameters()) - of_pose * J;
  root_ = triangular(M).bottomRightCorner(n, n);
}

void CramerRaoBound::update(const Eigen::Matrix3d& H_pose, const PoseSensitivity& H_parameters,
                            const Eigen::Matrix3d& R) {
  const Eigen::Index n = root_.cols();
  Eigen::MatrixXd M(n + 3, n);
  M.topRows(n) = root_;
  M.bottomRows<3>() << H_pose, H_parameters;
  const Eigen::LLT<Eigen::Matrix3d> llt(R);
  llt.matrixL().solveInPlace(M.bottomRows<3>());
  root_ = triangular(M);
}

void CramerRaoBound::add(const Eigen::MatrixXd& information) {
  const Eigen::Index n = root_.cols();
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n + parameters(), n);
  M.topRows(n) = root_;
  M.bottomRightCorner(parameters(), parameters()) = rootOf(information).transpose();
  root_ = triangular(M);
}

Eigen::MatrixXd CramerRaoBound::covariance() const {
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(root_.rows(), root_.cols());
  const Eigen::MatrixXd inverse = root_.triangularView<Eigen::Upper>().solve(identity);
  return inverse * inverse.transpose();
}

Eigen::VectorXd CramerRaoBound::deviations() const {
  return covariance().diagonal().tail(parameters()).cwiseSqrt();
}

}  // namespace bs_car_odometry::calibration
