#include "path_fit.hpp"

#include "fit.hpp"
#include "path_information.hpp"
#include "residuals.hpp"

#include "bs_car_odometry/calibration/observability.hpp"

#include <ceres/dynamic_autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace bs_car_odometry::calibration {

namespace {

constexpr int kMostIterations = 50;
constexpr double kPrecision = 1e-12;  // of the solver, relative change of the cost

/// All parameters, from those that are fitted and the values of the others.
template <typename T>
Eigen::Matrix<T, kCount, 1> completed(const ParameterVector& values, const std::vector<Eigen::Index>& fitted,
                                      const T* unknowns) {
  Eigen::Matrix<T, kCount, 1> all = values.cast<T>();
  for (std::size_t k = 0; k < fitted.size(); ++k) all[fitted[k]] = unknowns[k];
  return all;
}

/// Prior and (C13) for some of the parameters.
class BeliefResidual {
 public:
  BeliefResidual(const ParameterPrior& prior, const EvidenceResidual& evidence, const ParameterVector& values,
                 std::vector<Eigen::Index> fitted)
      : motion_prior_(prior),
        laser_prior_(prior),
        evidence_(evidence),
        values_(values),
        fitted_(std::move(fitted)) {}

  template <typename T>
  bool operator()(T const* const* unknowns, T* residuals) const {
    const auto all = completed(values_, fitted_, unknowns[0]);
    motion_prior_(all.data(), residuals);
    laser_prior_(all.data() + kMotionBlock, residuals + kMotionBlock);
    evidence_(all.data(), residuals + kMotionBlock + kLaserBlock);
    return true;
  }

  static constexpr int kResiduals = 2 * kMotionBlock + kLaserBlock;

 private:
  PriorResidual<0, kMotionBlock> motion_prior_;
  PriorResidual<kMotionBlock, kLaserBlock> laser_prior_;
  EvidenceResidual evidence_;
  ParameterVector values_;
  std::vector<Eigen::Index> fitted_;
};

ParameterMask observedOf(const ParameterPrior& prior, const ParameterMask& fitted,
                         const ParameterMatrix& covariance) {
  const Knowledge knowledge{fitted, prior.deviation, covariance.diagonal().cwiseMax(0.0).cwiseSqrt(), {}};
  ParameterMask observed{};
  for (std::size_t i = 0; i < kCount; ++i) observed[i] = knowledge.observed(i);
  return observed;
}

/// The delay is that of the likelihood: a path does not show it, and the noise of the turn rate at its
/// beginning, at the end of a long lever, looks as if it did.
ParameterPrior withDelay(ParameterPrior prior, const Refinement& likelihood, bool observed) {
  if (!observed) return prior;
  prior.mean[kTimeOffset] = likelihood.values[kTimeOffset];
  prior.deviation[kTimeOffset] = std::sqrt(likelihood.covariance(kTimeOffset, kTimeOffset));
  return prior;
}

/// The fit for one choice of the parameters that it may move.
class PathFit {
 public:
  PathFit(const ReckonedDrives& drives, const ParameterPrior& prior, const Refinement& likelihood)
      : drives_(drives), prior_(prior), likelihood_(likelihood), result_(likelihood) {
    for (std::size_t i = 0; i < drives_.count(); ++i) {
      const Evidence evidence = drives_.chain(i, likelihood.values).evidence;
      evidence_.information += evidence.information;
      evidence_.gradient += evidence.gradient;
    }
    result_.iterations = result_.rounds = 0;
  }

  const Refinement& result() const { return result_; }

  void run(const ParameterMask& fitted) {
    ParameterVector start = prior_.mean;
    std::vector<Eigen::Index> numbers;
    for (const Eigen::Index i : prior_.active) {
      if (!fitted[static_cast<std::size_t>(i)]) continue;
      numbers.push_back(i);
      start[i] = likelihood_.values[i];
    }
    result_.values = start;
    ++result_.rounds;
    if (!numbers.empty()) solve(numbers);
    PathInformation information(prior_);
    information.add(evidence_);
    for (std::size_t i = 0; i < drives_.count(); ++i) information.add(drives_.path(i, result_.values));
    result_.covariance = information.covariance(fitted);
  }

 private:
  void solve(const std::vector<Eigen::Index>& numbers) {
    Eigen::VectorXd unknowns(numbers.size());
    for (Eigen::Index k = 0; k < unknowns.size(); ++k)
      unknowns[k] = result_.values[numbers[static_cast<std::size_t>(k)]];
    ceres::Problem problem;
    problem.AddResidualBlock(new PathCost(drives_, result_.values, numbers), nullptr, unknowns.data());
    problem.AddResidualBlock(beliefs(numbers), nullptr, unknowns.data());
    for (Eigen::Index k = 0; k < unknowns.size(); ++k) {
      if (!hasBounds(static_cast<std::size_t>(numbers[static_cast<std::size_t>(k)]))) continue;
      problem.SetParameterLowerBound(unknowns.data(), static_cast<int>(k), kLeastGain);
      problem.SetParameterUpperBound(unknowns.data(), static_cast<int>(k), kLargestGain);
    }
    const ceres::Solver::Summary summary = solved(problem);
    take(numbers, unknowns, summary);
  }

  static ceres::Solver::Summary solved(ceres::Problem& problem) {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = kMostIterations;
    options.function_tolerance = kPrecision;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return summary;
  }

  void take(const std::vector<Eigen::Index>& numbers, const Eigen::VectorXd& unknowns,
            const ceres::Solver::Summary& summary) {
    result_.iterations += static_cast<int>(summary.iterations.size());
    result_.cost = summary.final_cost;
    result_.converged = summary.termination_type == ceres::CONVERGENCE && unknowns.allFinite();
    result_.at_bound = {};
    for (Eigen::Index k = 0; k < unknowns.size(); ++k) {
      const Eigen::Index i = numbers[static_cast<std::size_t>(k)];
      const auto p = static_cast<std::size_t>(i);
      result_.values[i] = unknowns[k];
      result_.at_bound[p] = hasBounds(p) && (unknowns[k] <= kLeastGain || unknowns[k] >= kLargestGain);
      if (result_.at_bound[p]) result_.converged = false;
    }
  }

  ceres::CostFunction* beliefs(const std::vector<Eigen::Index>& numbers) const {
    const EvidenceResidual evidence(evidence_, likelihood_.values, prior_.estimated);
    auto* cost = new ceres::DynamicAutoDiffCostFunction<BeliefResidual>(
        new BeliefResidual(prior_, evidence, result_.values, numbers));
    cost->AddParameterBlock(static_cast<int>(numbers.size()));
    cost->SetNumResiduals(BeliefResidual::kResiduals);
    return cost;
  }

  const ReckonedDrives& drives_;
  const ParameterPrior& prior_;
  const Refinement& likelihood_;
  Evidence evidence_;  ///< of all drives, about the values of the likelihood
  Refinement result_;
};

/// The fitted parameter that is furthest from being observed; none when all are.
std::optional<std::size_t> leastObserved(const ParameterPrior& prior, const ParameterMask& fitted,
                                         const ParameterMatrix& covariance) {
  const ParameterMask observed = observedOf(prior, fitted, covariance);
  std::optional<std::size_t> least;
  double largest = 0.0;
  for (const Eigen::Index i : prior.active) {
    const auto p = static_cast<std::size_t>(i);
    const double share = covariance(i, i) / (prior.deviation[i] * prior.deviation[i]);
    if (!fitted[p] || observed[p] || share < largest) continue;
    least = p;
    largest = share;
  }
  return least;
}

}  // namespace

ReckonedDrives::ReckonedDrives(const Drives& drives, const Parameters& parameters,
                               const Refinement& likelihood, const ChainOptions& options)
    : drives_(drives), parameters_(parameters), options_(options) {
  for (std::size_t i = 0; i < drives.size(); ++i) {
    trusted_.push_back(trustedPoses(*drives[i], likelihood.residuals[i]));
    any_poses_.resize(std::max(any_poses_.size(), lasers(i)));
  }
}

Chain ReckonedDrives::chain(std::size_t drive, const ParameterVector& values) const {
  return makeChain(*drives_[drive], parameters_, values, any_poses_, options_);
}

std::vector<PathPoint> ReckonedDrives::path(std::size_t drive, const ParameterVector& values) const {
  return reckonPath(chain(drive, values), values, trusted_[drive]);
}

PathCost::PathCost(const ReckonedDrives& drives, const ParameterVector& values,
                   std::vector<Eigen::Index> fitted)
    : drives_(drives), values_(values), fitted_(std::move(fitted)) {
  std::size_t lasers = 0;
  for (std::size_t i = 0; i < drives.count(); ++i) lasers += drives.lasers(i);
  set_num_residuals(static_cast<int>(2 * lasers));
  mutable_parameter_block_sizes()->push_back(static_cast<int>(fitted_.size()));
}

bool PathCost::Evaluate(double const* const* unknowns, double* residuals, double** jacobians) const {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const ParameterVector values = completed(values_, fitted_, unknowns[0]);
  const auto columns = static_cast<Eigen::Index>(fitted_.size());
  Eigen::Map<Eigen::VectorXd> r(residuals, num_residuals());
  Eigen::Map<RowMajor> J(jacobians ? jacobians[0] : nullptr, jacobians && jacobians[0] ? r.size() : 0,
                         columns);
  r.setZero();
  J.setZero();
  std::size_t before = 0;
  for (std::size_t i = 0; i < drives_.count(); ++i) {
    for (const PathPoint& point : drives_.path(i, values)) {
      if (point.begins || !point.trusted) continue;
      const auto row = static_cast<Eigen::Index>(2 * (before + point.laser));
      const Eigen::LLT<Eigen::Matrix2d> R(point.R.topLeftCorner<2, 2>());
      r.segment<2>(row) = R.matrixL().solve(point.reckoned - point.measured);
      for (Eigen::Index k = 0; k < columns && J.size() > 0; ++k)
        J.block<2, 1>(row, k) = R.matrixL().solve(point.J.col(fitted_[static_cast<std::size_t>(k)]));
    }
    before += drives_.lasers(i);
  }
  return true;
}

Refinement fitPath(const Drives& drives, const Parameters& parameters, const Refinement& likelihood,
                   const ChainOptions& options) {
  const ParameterPrior prior(parameters);
  ParameterMask fitted = observedOf(prior, prior.estimated, likelihood.covariance);
  const ParameterPrior kept = withDelay(prior, likelihood, fitted[kTimeOffset]);
  fitted[kTimeOffset] = false;
  const ReckonedDrives reckoned(drives, parameters, likelihood, options);
  PathFit fit(reckoned, kept, likelihood);
  fit.run(fitted);
  while (fit.result().converged) {
    const auto least = leastObserved(prior, fitted, fit.result().covariance);
    if (!least) break;
    fitted[*least] = false;
    fit.run(fitted);
  }
  return fit.result();
}

}  // namespace bs_car_odometry::calibration
