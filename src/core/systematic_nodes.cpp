#include "bs_car_odometry/core/systematic_nodes.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

namespace {

/// Inside a segment the nodes are moved to first order, which errs by about length (turn sigma)^2 / 8 with
/// sigma the standard deviation of a gain: below a micrometre.
constexpr double kSegmentLength = 0.25;  // [m]
constexpr double kSegmentTurn = 0.1;     // [rad]

/// The rule needs finite nodes; the fourth moment of a Student t is infinite up to 4 degrees of freedom.
constexpr double kLargestKurtosis = 9.0;

constexpr std::complex<double> kI(0.0, 1.0);

}  // namespace

/// Weighted sums over the nodes, from which the moments follow.
struct SystematicNodes::Sums {
  Complex mean;
  double norm{0.0};
  Complex square;
  Row with_a{};  ///< E[dz a_j]

  void add(double weight, Complex dz) {
    mean += weight * dz;
    norm += weight * std::norm(dz);
    square += weight * dz * dz;
  }
};

SystematicNodes::SystematicNodes(const SystematicPrior& prior) {
  for (std::size_t j = 0; j < prior.active.size(); ++j) {
    if (!prior.active[j]) continue;
    active_[dimensions_] = static_cast<Eigen::Index>(j);
    root_kurtosis_[dimensions_] = std::sqrt(std::min(prior.shape[j].kurtosis(), kLargestKurtosis));
    ++dimensions_;
  }
  double inverse_sum = 0.0;
  for (std::size_t j = 0; j < dimensions_; ++j) inverse_sum += std::pow(root_kurtosis_[j], -2);
  for (std::size_t j = 0; j < dimensions_; ++j) {
    const double inverse = std::pow(root_kurtosis_[j], -2);
    axis_weight_[j] = 0.5 * inverse * (1.0 - (inverse_sum - inverse));
  }
  reset();
}

void SystematicNodes::reset() {
  sensitivity_.setZero();
  curvature_.setZero();
  for (auto& nodes : axis_nodes_) nodes.fill(0.0);
  for (auto& nodes : pair_nodes_) nodes.fill(0.0);
  beginSegment();
}

void SystematicNodes::beginSegment() {
  begin_sensitivity_ = sensitivity_;
  displacement_ = 0.0;
  length_ = turn_ = 0.0;
}

SystematicNodes::Complex SystematicNodes::positionSensitivity(std::size_t j) const {
  return {sensitivity_(0, active_[j]), sensitivity_(1, active_[j])};
}

void SystematicNodes::advance(const PoseStep& step, const BodyMotion& motion,
                              const SystematicSensitivity& J_motion) {
  advanceSensitivity(step, J_motion, sensitivity_);
  displacement_ += Complex(step.dx, step.dy);
  length_ += std::abs(motion.x()) + std::abs(motion.y());
  turn_ += std::abs(motion.z());
  if (length_ > kSegmentLength || turn_ > kSegmentTurn) moveNodes();
}

/// A node drives the segment turned by the error of its heading at the beginning, phi a_k, and with its own
/// parameters: dz_k += e^{i phi a_k} (d + w a_k) - d, where w = dd/da seen from the beginning.
void SystematicNodes::moveNodes() {
  Row turn;
  Row reach;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    const double heading = begin_sensitivity_(2, active_[j]);
    const Complex begin(begin_sensitivity_(0, active_[j]), begin_sensitivity_(1, active_[j]));
    const double angle = root_kurtosis_[j] * heading;
    turn[j] = {std::cos(angle), std::sin(angle)};
    reach[j] = root_kurtosis_[j] * (positionSensitivity(j) - begin - kI * heading * displacement_);
  }
  Sums sums;
  moveAxes(turn, reach, sums);
  movePairs(turn, reach, sums);
  setMoments(sums);
  beginSegment();
}

void SystematicNodes::moveAxes(const Row& turn, const Row& reach, Sums& sums) {
  const Complex d = displacement_;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    auto& [plus, minus] = axis_nodes_[j];
    plus += turn[j] * (d + reach[j]) - d;
    minus += std::conj(turn[j]) * (d - reach[j]) - d;
    sums.add(axis_weight_[j], plus);
    sums.add(axis_weight_[j], minus);
    sums.with_a[j] += axis_weight_[j] * root_kurtosis_[j] * (plus - minus);
  }
}

void SystematicNodes::movePairs(const Row& turn, const Row& reach, Sums& sums) {
  const Complex d = displacement_;
  std::size_t pair = 0;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    for (std::size_t l = j + 1; l < dimensions_; ++l, ++pair) {
      const Complex same = turn[j] * turn[l];
      const Complex opposite = turn[j] * std::conj(turn[l]);
      auto& [pp, mm, pm, mp] = pair_nodes_[pair];
      pp += same * (d + reach[j] + reach[l]) - d;
      mm += std::conj(same) * (d - reach[j] - reach[l]) - d;
      pm += opposite * (d + reach[j] - reach[l]) - d;
      mp += std::conj(opposite) * (d - reach[j] + reach[l]) - d;
      const double weight = 0.25 * std::pow(root_kurtosis_[j] * root_kurtosis_[l], -2);
      for (const Complex& node : pair_nodes_[pair]) sums.add(weight, node);
      sums.with_a[j] += weight * root_kurtosis_[j] * (pp - mm + pm - mp);
      sums.with_a[l] += weight * root_kurtosis_[l] * (pp - mm - pm + mp);
    }
  }
}

/// The linear part goes to the sensitivity, so that it is carried on from step to step; the rest of the
/// covariance, which weights below zero may leave slightly negative, is brought to the nearest valid one.
void SystematicNodes::setMoments(const Sums& sums) {
  double trace = sums.norm - std::norm(sums.mean);
  Complex difference = sums.square - sums.mean * sums.mean;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    const Complex linear = sums.with_a[j];
    sensitivity_(0, active_[j]) = linear.real();
    sensitivity_(1, active_[j]) = linear.imag();
    trace -= std::norm(linear);
    difference -= linear * linear;
  }
  const double size = std::abs(difference);
  if (trace < size) {
    const double largest = std::max(0.5 * (trace + size), 0.0);
    trace = largest;
    difference = size > 0.0 ? difference * (largest / size) : 0.0;
  }
  curvature_(0, 0) = 0.5 * (trace + difference.real());
  curvature_(1, 1) = 0.5 * (trace - difference.real());
  curvature_(0, 1) = curvature_(1, 0) = 0.5 * difference.imag();
}

}  // namespace bs_car_odometry
