#include "fit.hpp"

#include "residuals.hpp"

#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::calibration {

namespace {

constexpr int kMostRounds = 15;
constexpr int kMostIterations = 50;    // of the solver, in a round
constexpr double kSettled = 0.01;      // standard deviations that a value may still move in the last round
constexpr double kNear = 1.0;          // standard deviations, below which slips are looked for
constexpr double kPrecision = 1e-10;   // of the solver, relative change of the cost
constexpr double kFirstRadius = 1e12;  // of its trust region: begins with a step of Gauss and Newton

template <int Begin, int Count>
ceres::CostFunction* priorCost(const ParameterPrior& prior) {
  using Residual = PriorResidual<Begin, Count>;
  return new ceres::AutoDiffCostFunction<Residual, Count, Count>(new Residual(prior));
}

ceres::Problem::Options sharedLoss() {
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

/// (C20) for all chains; their poses and `values` are its unknowns.
class FitProblem {
 public:
  FitProblem(std::vector<Chain>& chains, const ParameterPrior& prior, SlipPolicy slips,
             ParameterVector& values)
      : problem_(sharedLoss()),
        prior_(prior),
        motion_loss_(lossOf(slips)),
        linearised_(values),
        motion_(values.data()),
        laser_(values.data() + kMotionBlock) {
    problem_.AddResidualBlock(priorCost<0, kMotionBlock>(prior), nullptr, motion_);
    problem_.AddResidualBlock(priorCost<kMotionBlock, kLaserBlock>(prior), nullptr, laser_);
    setBounds();
    for (Chain& chain : chains) add(chain);
  }

  ceres::Solver::Summary solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = kMostIterations;
    options.function_tolerance = kPrecision;
    options.parameter_tolerance = kPrecision * kPrecision;
    options.gradient_tolerance = kPrecision * kPrecision;
    options.initial_trust_region_radius = kFirstRadius;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary;
  }

 private:
  ceres::LossFunction* lossOf(SlipPolicy slips) {
    if (slips == SlipPolicy::kNone) return nullptr;
    if (slips == SlipPolicy::kSoft) return &soft_loss_;
    return &slip_loss_;
  }

  void setBounds() {
    for (int i = 0; i < kMotionBlock; ++i) {
      if (!hasBounds(static_cast<std::size_t>(i))) continue;
      if (!prior_.estimated[static_cast<std::size_t>(i)]) continue;
      problem_.SetParameterLowerBound(motion_, i, kLeastGain);
      problem_.SetParameterUpperBound(motion_, i, kLargestGain);
    }
  }

  void add(Chain& chain) {
    using LaserCost = ceres::AutoDiffCostFunction<LaserPoseResidual, 3, 3, kLaserBlock>;
    using EvidenceCost = ceres::AutoDiffCostFunction<EvidenceResidual, kMotionBlock, kMotionBlock>;
    using MotionCost = ceres::AutoDiffCostFunction<MotionResidual, 3, 3, 3, kMotionBlock>;
    auto* evidence = new EvidenceResidual(chain.evidence, linearised_, prior_.estimated);
    problem_.AddResidualBlock(new EvidenceCost(evidence), nullptr, motion_);
    for (std::size_t i = 0; i < chain.nodes.size(); ++i) {
      Node& node = chain.nodes[i];
      auto* laser = new LaserPoseResidual(node, linearised_, prior_.estimated);
      problem_.AddResidualBlock(new LaserCost(laser), &soft_loss_, node.pose.data(), laser_);
      if (!node.linked) continue;
      auto* motion = new MotionResidual(node.link, linearised_, prior_.estimated);
      problem_.AddResidualBlock(new MotionCost(motion), motion_loss_, chain.nodes[i - 1].pose.data(),
                                node.pose.data(), motion_);
    }
  }

  SoftWeightLoss soft_loss_;
  SlipLoss slip_loss_;
  ceres::Problem problem_;
  const ParameterPrior& prior_;
  ceres::LossFunction* motion_loss_;
  ParameterVector linearised_;
  double* motion_;
  double* laser_;
};

ParameterVector withinBounds(ParameterVector values, const ParameterMask& estimated) {
  for (std::size_t i = 0; i < kCount; ++i)
    if (estimated[i] && hasBounds(i)) {
      double& value = values[static_cast<Eigen::Index>(i)];
      value = std::min(std::max(value, kLeastGain), kLargestGain);
    }
  return values;
}

}  // namespace

Fit::Fit(const Drives& drives, const Parameters& parameters, const RefinementOptions& options)
    : drives_(drives), parameters_(parameters), prior_(parameters), values_(prior_.mean) {
  std::size_t lasers = 0;
  for (const CalibrationDrive* drive : drives) {
    std::vector<Pose2> guesses;
    guesses.reserve(drive->lasers().size());
    for (const DriveLaser& laser : drive->lasers()) guesses.push_back(laser.guess);
    lasers += guesses.size();
    poses_.push_back(std::move(guesses));
  }
  chain_options_.laser_scales = options.laser_scales;
  chain_options_.stride = std::max<std::size_t>(1, (lasers + options.most_poses - 1) / options.most_poses);
  if (!options.seed) return;
  for (const Eigen::Index i : prior_.active) values_[i] = (*options.seed)[i];
  values_ = withinBounds(values_, prior_.estimated);
}

void Fit::run() {
  while (rounds_ < kMostRounds && !converged_) {
    ++rounds_;
    const ParameterVector before = values_;
    if (!makeChains()) break;
    const ceres::TerminationType end = solve();
    if (end == ceres::FAILURE) break;
    const double moved = movedBy(before);
    converged_ =
        end == ceres::CONVERGENCE && moved <= kSettled && (slips_ == SlipPolicy::kForgiven || !hasSlips());
    if (moved <= kNear) slips_ = slips_ == SlipPolicy::kNone ? SlipPolicy::kSoft : SlipPolicy::kForgiven;
  }
  const ParameterMask at_bound = atBound();
  if (std::any_of(at_bound.begin(), at_bound.end(), [](bool at) { return at; })) converged_ = false;
}

/// @return false when motion joins no two laser poses
bool Fit::makeChains() {
  chains_.clear();
  bool linked = false;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    chains_.push_back(makeChain(*drives_[i], parameters_, values_, poses_[i], chain_options_));
    for (const Node& node : chains_.back().nodes) linked = linked || node.linked;
  }
  return linked;
}

ceres::TerminationType Fit::solve() {
  ParameterVector values = values_;
  FitProblem problem(chains_, prior_, slips_, values);
  const ceres::Solver::Summary summary = problem.solve();
  iterations_ += static_cast<int>(summary.iterations.size());
  if (!summary.IsSolutionUsable() || !values.allFinite()) return ceres::FAILURE;
  cost_ = summary.final_cost;
  adopt(values);
  return summary.termination_type;
}

/// What the solver has found, for the next round and for what is linear about it.
void Fit::adopt(const ParameterVector& values) {
  const ParameterVector change = values - values_;
  values_ = values;
  for (std::size_t i = 0; i < chains_.size(); ++i) {
    Evidence& evidence = chains_[i].evidence;
    evidence.gradient -= evidence.information * change.head<kMotionBlock>();
    for (Node& node : chains_[i].nodes) {
      const Eigen::Vector3d moved = node.link.J * change.head<kMotionBlock>();
      node.link.motion = {node.link.motion.x + moved.x(), node.link.motion.y + moved.y(),
                          node.link.motion.yaw + moved.z()};
      poses_[i][node.laser] = {node.pose.x(), node.pose.y(), node.pose.z()};
    }
    setWeights(chains_[i]);
  }
  updateCovariance();
}

void Fit::setWeights(Chain& chain) const {
  for (std::size_t i = 0; i < chain.nodes.size(); ++i) {
    Node& node = chain.nodes[i];
    if (node.linked)
      node.link.weight =
          SlipLoss::weight(normalisedSquare(motionResidual(chain.nodes[i - 1], node), node.link.noise));
    node.weight = SoftWeightLoss::weight(normalisedSquare(laserResidual(node, values_), node.covariance));
  }
}

void Fit::updateCovariance() {
  ChainFilter filter(prior_, values_);
  for (const Chain& chain : chains_) filter.add(chain);
  covariance_ = filter.covariance();
}

/// Largest change of a value, in standard deviations.
double Fit::movedBy(const ParameterVector& before) const {
  double largest = 0.0;
  for (const Eigen::Index i : prior_.active)
    largest = std::max(largest, std::abs(values_[i] - before[i]) / std::sqrt(covariance_(i, i)));
  return largest;
}

bool Fit::hasSlips() const {
  const auto slips = [](const Node& node) { return node.linked && node.link.weight < 1.0; };
  return std::any_of(chains_.begin(), chains_.end(), [&](const Chain& chain) {
    return std::any_of(chain.nodes.begin(), chain.nodes.end(), slips);
  });
}

ParameterMask Fit::atBound() const {
  ParameterMask at_bound{};
  for (std::size_t i = 0; i < kCount; ++i) {
    const double value = values_[static_cast<Eigen::Index>(i)];
    at_bound[i] = prior_.estimated[i] && hasBounds(i) && (value <= kLeastGain || value >= kLargestGain);
  }
  return at_bound;
}

Refinement Fit::result() const {
  Refinement result;
  result.values = values_;
  result.covariance = covariance_;
  result.estimated = prior_.estimated;
  result.at_bound = atBound();
  result.converged = converged_;
  result.cost = cost_;
  result.rounds = rounds_;
  result.iterations = iterations_;
  for (const Chain& chain : chains_) {
    std::vector<LaserResidual> residuals;
    residuals.reserve(chain.nodes.size());
    for (const Node& node : chain.nodes) {
      const Eigen::Vector3d residual = laserResidual(node, values_);
      const Pose2 pose{node.pose.x(), node.pose.y(), node.pose.z()};
      residuals.push_back(
          {node.laser, pose, residual, normalisedSquare(residual, node.covariance), node.weight});
    }
    result.residuals.push_back(std::move(residuals));
  }
  return result;
}

std::vector<Chain> Fit::chainsWithWheelNoise() const {
  ChainOptions options = chain_options_;
  options.wheel_covariance = true;
  std::vector<Chain> chains;
  for (std::size_t i = 0; i < drives_.size(); ++i)
    chains.push_back(makeChain(*drives_[i], parameters_, values_, poses_[i], options));
  return chains;
}

}  // namespace bs_car_odometry::calibration
