#include "noise_likelihood.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::calibration {

namespace {

constexpr int kMostSteps = 50;
constexpr int kMostSelections = 15;
constexpr double kLongestStep = 1.0;    // in the logarithm of a level: a factor of e
constexpr double kLargestLog = 5.0;     // levels further away than a factor of 150 are not looked for
constexpr double kSettled = 0.01;       // standard deviations
constexpr double kDifference = 1e-3;    // of the derivatives: truncation 1e-6, rounding 1e-12
constexpr double kTooUncertain = 0.35;  // standard deviation of a logarithm beyond which a level is not known
constexpr double kMedianPosition = 1.386;  // of a chi-square with 2 degrees of freedom
constexpr double kMedianYaw = 0.455;       // with 1

/// Without the largest 0.1 % of the poses the mean square of the others is too small by so much:
/// P(chi2_5 < limit) / P(chi2_3 < limit) at kRejectLimit.
constexpr double kTruncation = 0.99488;

using Innovations = std::vector<ChainInnovation>;

NoiseScales scalesOf(const LevelVector& logs) {
  return {std::exp(logs[0]), {std::exp(logs[1]), std::exp(logs[2])}};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Gradient of the logarithm of the likelihood, and Fisher's information.
struct Score {
  LevelVector gradient{LevelVector::Zero()};
  Eigen::Matrix3d information{Eigen::Matrix3d::Zero()};
};

class LevelSearch {
 public:
  LevelSearch(std::vector<Chain>& chains, const ParameterPrior& prior, const ParameterVector& values)
      : chains_(chains), prior_(prior), values_(values) {}

  LevelEstimate run() {
    cutSlips();
    if (!beginRobustly()) return estimate_;
    do {
      climb();
    } while (dropUncertain());
    for (std::size_t k = 1; k < kLevels; ++k)
      if (estimate_.found[k]) estimate_.logs[static_cast<Eigen::Index>(k)] -= 0.5 * std::log(kTruncation);
    return estimate_;
  }

 private:
  /// Motion that the fit does not believe says nothing of the noise.
  void cutSlips() {
    for (Chain& chain : chains_)
      for (std::size_t i = 1; i < chain.nodes.size(); ++i) {
        Node& node = chain.nodes[i];
        const Eigen::Vector3d residual = motionResidual(chain.nodes[i - 1], node);
        if (normalisedSquare(residual, node.link.noise) > kSoftLimit) node.linked = false;
      }
  }

  /// From medians, which do not see outliers nor whether the levels were right.
  /// @return false where there are no poses
  bool beginRobustly() {
    std::vector<double> position;
    std::vector<double> yaw;
    for (const Chain& chain : chains_)
      for (const Node& node : chain.nodes) {
        const Eigen::Vector3d r = laserResidual(node, values_);
        const Eigen::Vector2d p = r.head<2>();
        position.push_back(p.dot(node.covariance.topLeftCorner<2, 2>().llt().solve(p)));
        yaw.push_back(r.z() * r.z() / node.covariance(2, 2));
      }
    if (yaw.empty()) return false;
    estimate_.found = {true, true, true};
    estimate_.logs[1] = startLog(median(position) / kMedianPosition);
    estimate_.logs[2] = startLog(median(yaw) / kMedianYaw);
    return true;
  }

  static double startLog(double ratio) {
    return std::min(std::max(0.5 * std::log(ratio), -kLargestLog), kLargestLog);
  }

  /// Fisher scoring.
  void climb() {
    estimate_.converged = false;
    for (int i = 0; i < kMostSteps && !estimate_.converged; ++i) {
      // Later on, a pose that comes and goes at the limit would keep the search from its end.
      if (i < kMostSelections) leaveOutliersOut();
      const Score score = scoreAt(estimate_.logs);
      const Eigen::LLT<Eigen::Matrix3d> information(score.information);
      const Eigen::Matrix3d covariance = information.solve(Eigen::Matrix3d::Identity());
      LevelVector step = information.solve(score.gradient);
      estimate_.deviations = covariance.diagonal().cwiseSqrt();
      estimate_.converged = (step.array().abs() <= kSettled * estimate_.deviations.array()).all();
      step *= std::min(1.0, kLongestStep / step.cwiseAbs().maxCoeff());
      estimate_.logs = (estimate_.logs + step).cwiseMax(-kLargestLog).cwiseMin(kLargestLog);
    }
  }

  void leaveOutliersOut() {
    const NoiseScales scales = scalesOf(estimate_.logs);
    std::size_t poses = 0;
    std::size_t outliers = 0;
    for (Chain& chain : chains_)
      for (Node& node : chain.nodes) {
        const Eigen::Matrix3d R = scaled(node.covariance, scales.laser);
        node.weight = normalisedSquare(laserResidual(node, values_), R) > kRejectLimit ? 0.0 : 1.0;
        outliers += node.weight == 0.0 ? 1 : 0;
        ++poses;
      }
    estimate_.outliers = static_cast<double>(outliers) / static_cast<double>(poses);
  }

  Innovations innovationsAt(const LevelVector& logs) const {
    ChainFilter filter(prior_, values_);
    Innovations innovations;
    for (const Chain& chain : chains_) filter.add(chain, scalesOf(logs), &innovations);
    return innovations;
  }

  Score scoreAt(const LevelVector& logs) const {
    const Innovations innovations = innovationsAt(logs);
    std::array<Innovations, kLevels> above;
    std::array<Innovations, kLevels> below;
    for (int k = 0; k < kLevels; ++k) {
      if (!estimate_.found[static_cast<std::size_t>(k)]) continue;
      above[static_cast<std::size_t>(k)] = innovationsAt(logs + kDifference * LevelVector::Unit(k));
      below[static_cast<std::size_t>(k)] = innovationsAt(logs - kDifference * LevelVector::Unit(k));
    }
    Score score;
    for (int k = 0; k < kLevels; ++k)
      if (!estimate_.found[static_cast<std::size_t>(k)]) score.information(k, k) = 1.0;
    for (std::size_t i = 0; i < innovations.size(); ++i) add(innovations[i], above, below, i, score);
    return score;
  }

  /// (C26), (C27) for one innovation.
  void add(const ChainInnovation& innovation, const std::array<Innovations, kLevels>& above,
           const std::array<Innovations, kLevels>& below, std::size_t i, Score& score) const {
    const Eigen::Matrix3d inverse = innovation.covariance.llt().solve(Eigen::Matrix3d::Identity());
    const Eigen::Vector3d weighted = inverse * innovation.residual;
    std::array<Eigen::Vector3d, kLevels> dr;
    std::array<Eigen::Matrix3d, kLevels> dS;  // S^-1 dS
    for (std::size_t k = 0; k < kLevels; ++k) {
      if (!estimate_.found[k]) continue;
      dr[k] = (above[k][i].residual - below[k][i].residual) / (2.0 * kDifference);
      dS[k] = inverse * (above[k][i].covariance - below[k][i].covariance) / (2.0 * kDifference);
      const auto row = static_cast<Eigen::Index>(k);
      score.gradient[row] +=
          0.5 * innovation.residual.dot(dS[k] * weighted) - 0.5 * dS[k].trace() - dr[k].dot(weighted);
      for (std::size_t l = 0; l <= k; ++l) {
        if (!estimate_.found[l]) continue;
        const auto column = static_cast<Eigen::Index>(l);
        score.information(row, column) += 0.5 * (dS[k] * dS[l]).trace() + dr[k].dot(inverse * dr[l]);
        score.information(column, row) = score.information(row, column);
      }
    }
  }

  /// A level that the drives say too little of stays as it was.
  bool dropUncertain() {
    Eigen::Index worst = 0;
    LevelVector deviations = estimate_.deviations;
    for (std::size_t k = 0; k < kLevels; ++k)
      if (!estimate_.found[k]) deviations[static_cast<Eigen::Index>(k)] = 0.0;
    estimate_.deviations = deviations;
    if (deviations.maxCoeff(&worst) <= kTooUncertain) return false;
    estimate_.found[static_cast<std::size_t>(worst)] = false;
    estimate_.logs[worst] = 0.0;
    return true;
  }

  std::vector<Chain>& chains_;
  const ParameterPrior& prior_;
  const ParameterVector& values_;
  LevelEstimate estimate_;
};

}  // namespace

LevelEstimate fitLevels(std::vector<Chain>& chains, const ParameterPrior& prior,
                        const ParameterVector& values) {
  return LevelSearch(chains, prior, values).run();
}

}  // namespace bs_car_odometry::calibration
