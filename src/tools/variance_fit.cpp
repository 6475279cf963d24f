#include "variance_fit.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace bs_car_odometry::tools {

namespace {

using Function = std::function<double(const Eigen::VectorXd&)>;

constexpr double kStep = 0.02;       // of the differences: truncation 1e-4, rounding of a likelihood 1e-5
constexpr double kLongest = 2.0;     // of a Newton step, in the logarithm of a variance
constexpr double kConverged = 1e-7;  // gain of the likelihood that another step would promise
constexpr double kNothing = 1e-4;    // loss of the likelihood that a variance of zero may cost
constexpr int kMostSteps = 200;

struct Derivatives {
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
};

Derivatives differences(const Function& f, const Eigen::VectorXd& x, double value) {
  const Eigen::Index n = x.size();
  const auto at = [&](Eigen::Index i, double di, Eigen::Index j, double dj) {
    Eigen::VectorXd moved = x;
    moved[i] += di;
    moved[j] += dj;
    return f(moved);
  };
  Derivatives d{Eigen::VectorXd(n), Eigen::MatrixXd(n, n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const double above = at(i, kStep, i, 0.0);
    const double below = at(i, -kStep, i, 0.0);
    d.gradient[i] = (above - below) / (2.0 * kStep);
    d.hessian(i, i) = (above - 2.0 * value + below) / (kStep * kStep);
    for (Eigen::Index j = 0; j < i; ++j) {
      const double mixed = at(i, kStep, j, kStep) - at(i, kStep, j, -kStep) - at(i, -kStep, j, kStep) +
                           at(i, -kStep, j, -kStep);
      d.hessian(i, j) = d.hessian(j, i) = mixed / (4.0 * kStep * kStep);
    }
  }
  return d;
}

/// Uphill also where the function is not concave: curvatures count by their size, and by no less than a
/// little.
Eigen::VectorXd newtonStep(const Derivatives& d) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(d.hessian);
  const Eigen::VectorXd curvature = solver.eigenvalues().cwiseAbs().cwiseMax(1e-6);
  const Eigen::MatrixXd& V = solver.eigenvectors();
  const Eigen::VectorXd step = V * (V.transpose() * d.gradient).cwiseQuotient(curvature);
  return step * std::min(1.0, kLongest / std::max(step.cwiseAbs().maxCoeff(), 1e-300));
}

/// Climbs from x, which becomes the maximum. @return its value
double climb(const Function& f, Eigen::VectorXd& x) {
  double value = f(x);
  if (!std::isfinite(value)) throw std::runtime_error("the likelihood is not finite at the start");
  for (int i = 0; i < kMostSteps && x.size() > 0; ++i) {
    const Derivatives d = differences(f, x, value);
    Eigen::VectorXd step = newtonStep(d);
    if (d.gradient.dot(step) < kConverged) return value;
    double next = f(x + step);
    for (int halved = 0; !(next > value) && halved < 30; ++halved) {
      step *= 0.5;
      next = f(x + step);
    }
    if (!(next > value)) return value;
    x += step;
    value = next;
  }
  if (x.size() > 0) throw std::runtime_error("no maximum of the likelihood was found");
  return value;
}

/// The sought variances within all of them.
class Active {
 public:
  explicit Active(const Eigen::VectorXd& start) : log_variances_(start.array().log()) {
    for (Eigen::Index i = 0; i < start.size(); ++i) indices_.push_back(i);
  }

  Eigen::VectorXd logs() const {
    Eigen::VectorXd x(size());
    for (Eigen::Index i = 0; i < size(); ++i) x[i] = log_variances_[indices_[static_cast<std::size_t>(i)]];
    return x;
  }
  void setLogs(const Eigen::VectorXd& x) {
    for (Eigen::Index i = 0; i < size(); ++i) log_variances_[indices_[static_cast<std::size_t>(i)]] = x[i];
  }
  /// All variances, 0 where none is sought.
  Eigen::VectorXd expand(const Eigen::VectorXd& x) const {
    Eigen::VectorXd variances = Eigen::VectorXd::Zero(log_variances_.size());
    for (Eigen::Index i = 0; i < size(); ++i)
      variances[indices_[static_cast<std::size_t>(i)]] = std::exp(x[i]);
    return variances;
  }
  void remove(Eigen::Index i) { indices_.erase(indices_.begin() + i); }
  Eigen::Index size() const { return static_cast<Eigen::Index>(indices_.size()); }
  Eigen::Index operator[](Eigen::Index i) const { return indices_[static_cast<std::size_t>(i)]; }

 private:
  Eigen::VectorXd log_variances_;
  std::vector<Eigen::Index> indices_;
};

/// Leaves out the variance whose absence costs the likelihood least, where that is next to nothing.
bool leaveOneOut(const Function& likelihood, double value, Active& active) {
  Eigen::Index best = -1;
  double best_value = value - kNothing;
  for (Eigen::Index i = 0; i < active.size(); ++i) {
    Eigen::VectorXd variances = active.expand(active.logs());
    variances[active[i]] = 0.0;
    const double without = likelihood(variances);
    if (!(without >= best_value)) continue;
    best = i;
    best_value = without;
  }
  if (best >= 0) active.remove(best);
  return best >= 0;
}

Eigen::VectorXd stdOfRoots(const Function& f, const Active& active, double value, Eigen::Index all) {
  Eigen::VectorXd std = Eigen::VectorXd::Zero(all);
  if (active.size() == 0) return std;
  const Eigen::VectorXd x = active.logs();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(-differences(f, x, value).hessian);
  const Eigen::VectorXd inverse = solver.eigenvalues().cwiseMax(1e-12).cwiseInverse();
  const Eigen::MatrixXd covariance =
      solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
  for (Eigen::Index i = 0; i < active.size(); ++i)
    std[active[i]] = 0.5 * std::exp(0.5 * x[i]) * std::sqrt(covariance(i, i));
  return std;
}

}  // namespace

VarianceFit fitVariances(const Function& log_likelihood, const Eigen::VectorXd& start) {
  Active active(start);
  const auto f = [&](const Eigen::VectorXd& x) { return log_likelihood(active.expand(x)); };
  double value = 0.0;
  do {
    Eigen::VectorXd x = active.logs();
    value = climb(f, x);
    active.setLogs(x);
  } while (leaveOneOut(log_likelihood, value, active));
  return {active.expand(active.logs()), stdOfRoots(f, active, value, start.size()), value};
}

}  // namespace bs_car_odometry::tools
