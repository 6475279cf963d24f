#include "bs_car_odometry/core/systematic_nodes.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

namespace {

/// Inside a segment the nodes are moved to first order, which errs by about length (turn sigma)^2 / 8 with
/// sigma the standard deviation of a gain: below a micrometre.
constexpr double kSegmentLength = 0.25;  // [m]
constexpr double kSegmentTurn = 0.1;     // [rad]

/// Tails heavier than this are left to the Gaussian of the same standard deviation: the nodes would run away.
constexpr double kLargestKurtosis = 9.0;

/// The symmetric Gauss rule of five points for the moments 1, m4, m6, m8: 0, +-place[i].
struct GaussRule {
  std::array<double, 2> place;
  std::array<double, 2> weight;
};

/// The squares of the places are the roots of u^2 + b u + c, which is orthogonal to 1 and u under the weight
/// u.
GaussRule gaussRule(const Distribution& shape) {
  const double m4 = shape.standardMoment(4);
  const double m6 = shape.standardMoment(6);
  const double m8 = shape.standardMoment(8);
  const double b = (m4 * m6 - m8) / (m6 - m4 * m4);
  const double c = -(m6 + b * m4);
  const double root = std::sqrt(0.25 * b * b - c);
  const double u1 = -0.5 * b - root;
  const double u2 = -0.5 * b + root;
  return {{std::sqrt(u1), std::sqrt(u2)},
          {0.5 * (m4 - u2) / (u1 * (u1 - u2)), 0.5 * (m4 - u1) / (u2 * (u2 - u1))}};
}

Distribution withLightTails(const Distribution& shape) {
  const bool heavy = !(shape.kurtosis() <= kLargestKurtosis) || !std::isfinite(shape.standardMoment(8));
  return heavy ? Distribution(1.0) : shape;
}

constexpr std::complex<double> kI(0.0, 1.0);

}  // namespace

/// Weighted sums over the nodes.
struct SystematicNodes::Sums {
  Complex mean;
  double norm{0.0};
  Complex square;
  Complex backward;
  Complex forward;
  double turn_mean{0.0};
  double turn_square{0.0};
  std::array<Complex, systematic::kCount> with_a{};  ///< E[dz a_j]

  /// Two nodes that lie opposite to each other, at +-a.
  void add(double weight, Complex plus, Complex minus, Complex turn) {
    const Complex sum = weight * (plus + minus);
    mean += sum;
    norm += weight * (std::norm(plus) + std::norm(minus));
    square += weight * (plus * plus + minus * minus);
    backward += weight * (plus * std::conj(turn) + minus * turn);
    forward += weight * (plus * turn + minus * std::conj(turn));
    turn_mean += 2.0 * weight * (turn.real() - 1.0);
    turn_square += 2.0 * weight * ((turn * turn).real() - 1.0);
  }
};

SystematicNodes::SystematicNodes(const SystematicPrior& prior) {
  for (std::size_t j = 0; j < prior.active.size(); ++j)
    if (prior.active[j]) addAxis(static_cast<Eigen::Index>(j), withLightTails(prior.shape[j]));
  double inverse_sum = 0.0;
  for (std::size_t j = 0; j < dimensions_; ++j) inverse_sum += std::pow(axes_[j].place[0], -2);
  // What the pairs have too much of each component alone.
  for (std::size_t j = 0; j < dimensions_; ++j) {
    const double inverse = std::pow(axes_[j].place[0], -2);
    axes_[j].weight[0] = -0.5 * inverse * (inverse_sum - inverse);
  }
  reset();
}

void SystematicNodes::addAxis(Eigen::Index component, const Distribution& shape) {
  const GaussRule rule = gaussRule(shape);
  Axis& axis = axes_[dimensions_++];
  axis.component = component;
  axis.place = {std::sqrt(shape.kurtosis()), rule.place[0], rule.place[1]};
  axis.weight = {0.0, rule.weight[0], rule.weight[1]};
}

void SystematicNodes::reset() {
  sensitivity_.setZero();
  for (Axis& axis : axes_) {
    axis.turn.fill(1.0);
    axis.plus.fill(0.0);
    axis.minus.fill(0.0);
  }
  for (auto& nodes : pair_nodes_) nodes.fill(0.0);
  setMoments(weightedSums());
  beginSegment();
}

void SystematicNodes::beginSegment() {
  begin_sensitivity_ = sensitivity_;
  displacement_ = 0.0;
  length_ = turn_ = 0.0;
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
  const SystematicSensitivity change = sensitivity_ - begin_sensitivity_;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    Axis& axis = axes_[j];
    const double heading = begin_sensitivity_(2, axis.component);
    axis.w = Complex(change(0, axis.component), change(1, axis.component)) - kI * heading * displacement_;
    moveAxis(axis);
  }
  movePairs();
  for (std::size_t j = 0; j < dimensions_; ++j)
    for (std::size_t i = 0; i < axes_[j].place.size(); ++i)
      axes_[j].turn[i] = std::polar(1.0, axes_[j].place[i] * sensitivity_(2, axes_[j].component));
  setMoments(weightedSums());
  beginSegment();
}

void SystematicNodes::moveAxis(Axis& axis) {
  const Complex d = displacement_;
  for (std::size_t i = 0; i < axis.place.size(); ++i) {
    const Complex own = axis.place[i] * axis.w;
    axis.plus[i] += axis.turn[i] * (d + own) - d;
    axis.minus[i] += std::conj(axis.turn[i]) * (d - own) - d;
  }
}

void SystematicNodes::movePairs() {
  const Complex d = displacement_;
  std::size_t pair = 0;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    for (std::size_t l = j + 1; l < dimensions_; ++l, ++pair) {
      const Complex same = axes_[j].turn[0] * axes_[l].turn[0];
      const Complex opposite = axes_[j].turn[0] * std::conj(axes_[l].turn[0]);
      const Complex own_j = axes_[j].place[0] * axes_[j].w;
      const Complex own_l = axes_[l].place[0] * axes_[l].w;
      auto& [pp, mm, pm, mp] = pair_nodes_[pair];
      pp += same * (d + own_j + own_l) - d;
      mm += std::conj(same) * (d - own_j - own_l) - d;
      pm += opposite * (d + own_j - own_l) - d;
      mp += std::conj(opposite) * (d - own_j + own_l) - d;
    }
  }
}

SystematicNodes::Sums SystematicNodes::weightedSums() const {
  Sums sums;
  sums.turn_mean = sums.turn_square = 1.0;
  std::size_t pair = 0;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    const Axis& axis = axes_[j];
    for (std::size_t i = 0; i < axis.place.size(); ++i) {
      sums.add(axis.weight[i], axis.plus[i], axis.minus[i], axis.turn[i]);
      sums.with_a[j] += axis.weight[i] * axis.place[i] * (axis.plus[i] - axis.minus[i]);
    }
    for (std::size_t l = j + 1; l < dimensions_; ++l, ++pair) {
      const auto& [pp, mm, pm, mp] = pair_nodes_[pair];
      const double place_j = axis.place[0];
      const double place_l = axes_[l].place[0];
      const double weight = 0.25 / (place_j * place_j * place_l * place_l);
      sums.add(weight, pp, mm, axis.turn[0] * axes_[l].turn[0]);
      sums.add(weight, pm, mp, axis.turn[0] * std::conj(axes_[l].turn[0]));
      sums.with_a[j] += weight * place_j * (pp - mm + pm - mp);
      sums.with_a[l] += weight * place_l * (pp - mm - pm + mp);
    }
  }
  return sums;
}

/// The linear part goes to the sensitivity, so that it is carried on from step to step.
void SystematicNodes::setMoments(const Sums& sums) {
  mean_ = sums.mean;
  norm_ = sums.norm;
  square_ = sums.square;
  backward_ = sums.backward;
  forward_ = sums.forward;
  turn_mean_ = sums.turn_mean;
  turn_square_ = sums.turn_square;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    sensitivity_(0, axes_[j].component) = sums.with_a[j].real();
    sensitivity_(1, axes_[j].component) = sums.with_a[j].imag();
  }
}

/// Since the nodes were last moved they have gone on by e^{i delta} (d + w a) - d. Of the moments of that,
/// those of e^{i delta} d are taken as they are, and w a counts in the sensitivity alone. Weights below zero
/// may leave a slightly negative variance, so that the nearest valid matrix is given.
Eigen::Matrix2d SystematicNodes::curvature() const {
  const Complex d = displacement_;
  const Complex mean = lag();
  double trace = norm_ + 2.0 * (std::conj(d) * (backward_ - mean_)).real() +
                 2.0 * (1.0 - turn_mean_) * std::norm(d) - std::norm(mean);
  Complex difference =
      square_ + 2.0 * d * (forward_ - mean_) + (turn_square_ - 2.0 * turn_mean_ + 1.0) * d * d - mean * mean;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    const Eigen::Index k = axes_[j].component;
    const Complex linear =
        Complex(begin_sensitivity_(0, k), begin_sensitivity_(1, k)) + kI * begin_sensitivity_(2, k) * d;
    trace -= std::norm(linear);
    difference -= linear * linear;
  }
  const double size = std::abs(difference);
  if (trace < size) {
    const double largest = std::max(0.5 * (trace + size), 0.0);
    trace = largest;
    difference = size > 0.0 ? difference * (largest / size) : 0.0;
  }
  Eigen::Matrix2d curvature;
  curvature << trace + difference.real(), difference.imag(), difference.imag(), trace - difference.real();
  return 0.5 * curvature;
}

}  // namespace bs_car_odometry
