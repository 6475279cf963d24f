#include "independent_spread.hpp"

#include <Eigen/QR>

#include <algorithm>
#include <limits>

namespace bs_car_odometry::tools {

namespace {

/// Least squares min x^T A x - 2 b^T x over the variables that `chosen` has bits for, the others 0.
Eigen::VectorXd solveSubset(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, unsigned chosen) {
  std::vector<Eigen::Index> indices;
  for (Eigen::Index k = 0; k < b.size(); ++k)
    if ((chosen >> static_cast<unsigned>(k)) & 1U) indices.push_back(k);
  const auto n = static_cast<Eigen::Index>(indices.size());
  Eigen::MatrixXd part(n, n);
  Eigen::VectorXd right(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    right[i] = b[indices[static_cast<std::size_t>(i)]];
    for (Eigen::Index j = 0; j < n; ++j)
      part(i, j) = A(indices[static_cast<std::size_t>(i)], indices[static_cast<std::size_t>(j)]);
  }
  const Eigen::VectorXd solution = part.colPivHouseholderQr().solve(right);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size());
  for (Eigen::Index i = 0; i < n; ++i) x[indices[static_cast<std::size_t>(i)]] = solution[i];
  return x;
}

/// The best of them that is nowhere negative; there are few variables, so all subsets are tried.
Eigen::VectorXd solveNonNegative(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  Eigen::VectorXd best = Eigen::VectorXd::Zero(b.size());
  double least = 0.0;
  for (unsigned chosen = 1; chosen < (1U << static_cast<unsigned>(b.size())); ++chosen) {
    const Eigen::VectorXd x = solveSubset(A, b, chosen);
    const double objective = x.dot(A * x) - 2.0 * b.dot(x);
    if (x.minCoeff() < 0.0 || !(objective < least)) continue;
    best = x;
    least = objective;
  }
  return best;
}

}  // namespace

Eigen::VectorXd independentVariances(const std::vector<GainEffect>& effects,
                                     const std::vector<std::size_t>& keys) {
  const Eigen::Index n =
      keys.empty() ? 0 : static_cast<Eigen::Index>(*std::max_element(keys.begin(), keys.end())) + 1;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (const GainEffect& effect : effects) {
    const Eigen::MatrixXd& J = effect.sensitivity;
    const Eigen::MatrixXd wanted = J * effect.covariance * J.transpose();
    std::vector<Eigen::MatrixXd> of_keys(static_cast<std::size_t>(n),
                                         Eigen::MatrixXd::Zero(J.rows(), J.rows()));
    for (Eigen::Index j = 0; j < J.cols(); ++j)
      of_keys[keys[static_cast<std::size_t>(j)]] += J.col(j) * J.col(j).transpose();
    for (Eigen::Index k = 0; k < n; ++k) {
      const Eigen::MatrixXd& of_k = of_keys[static_cast<std::size_t>(k)];
      b[k] += of_k.cwiseProduct(wanted).sum();
      for (Eigen::Index l = 0; l < n; ++l)
        A(k, l) += of_k.cwiseProduct(of_keys[static_cast<std::size_t>(l)]).sum();
    }
  }
  return solveNonNegative(A, b);
}

}  // namespace bs_car_odometry::tools
