#include "bs_car_odometry/core/systematic_nodes.hpp"

#include "bs_car_odometry/core/first_order_covariance.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

namespace {

/// Inside a segment the nodes are moved to first order, which errs by about length (turn sigma)^2 / 8 with
/// sigma the standard deviation of a gain: below a micrometre.
constexpr double kSegmentLength = 0.5;  // [m]
constexpr double kSegmentTurn = 0.25;   // [rad]

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

SystematicNodes::SystematicNodes(const SystematicPrior& prior) {
  for (std::size_t j = 0; j < prior.active.size(); ++j)
    if (prior.active[j]) addAxis(static_cast<Eigen::Index>(j), withLightTails(prior.shape[j]));
  for (std::size_t j = 0; j < dimensions_; ++j) addPairs(j);
  reset(Eigen::Matrix3d::Zero());
}

void SystematicNodes::addAxis(Eigen::Index component, const Distribution& shape) {
  const GaussRule rule = gaussRule(shape);
  axes_[dimensions_].component = component;
  axes_[dimensions_].place = {std::sqrt(shape.kurtosis()), rule.place[0], rule.place[1]};
  for (std::size_t place = 1; place < 3; ++place) {
    Opposites& nodes = nodes_[count_++];
    nodes.weight = rule.weight[place - 1];
    nodes.axis = dimensions_;
    nodes.place = place;
  }
  ++dimensions_;
}

/// Pairs with the axes behind, and what all pairs have too much of this axis alone.
void SystematicNodes::addPairs(std::size_t axis) {
  const auto per_kurtosis = [this](std::size_t j) { return std::pow(axes_[j].place[0], -2); };
  double others = 0.0;
  for (std::size_t other = 0; other < dimensions_; ++other) {
    if (other != axis) others += per_kurtosis(other);
    if (other <= axis) continue;
    for (const double sign : {1.0, -1.0}) {
      Opposites& nodes = nodes_[count_++];
      nodes.weight = 0.25 * per_kurtosis(axis) * per_kurtosis(other);
      nodes.axis = axis;
      nodes.second_axis = other;
      nodes.second_sign = sign;
    }
  }
  if (others == 0.0) return;
  Opposites& nodes = nodes_[count_++];
  nodes.weight = -0.5 * per_kurtosis(axis) * others;
  nodes.axis = axis;
}

void SystematicNodes::reset(const Eigen::Matrix3d& covariance) {
  sensitivity_.setZero();
  for (Axis& axis : axes_) axis.turn.fill(1.0);
  nominal_ = NodeNoise();
  for (Opposites& nodes : nodes_) nodes.plus = nodes.minus = Node();
  noise_heading_ = 0.0;
  beginSegment();
  inflate(covariance);
  setMoments();
}

void SystematicNodes::inflate(const Eigen::Matrix3d& covariance) {
  const auto add = [&covariance](NodeNoise& noise) {
    noise.norm += covariance(0, 0) + covariance(1, 1);
    noise.square += Complex(covariance(0, 0) - covariance(1, 1), 2.0 * covariance(0, 1));
    noise.heading += Complex(covariance(0, 2), covariance(1, 2));
  };
  add(nominal_);
  for (std::size_t k = 0; k < count_; ++k) {
    add(nodes_[k].plus.noise);
    add(nodes_[k].minus.noise);
  }
  noise_heading_ += covariance(2, 2);
}

void SystematicNodes::beginSegment() {
  begin_sensitivity_ = sensitivity_;
  segment_noise_.setZero();
  displacement_ = 0.0;
  length_ = turn_ = 0.0;
}

void SystematicNodes::advance(const PoseStep& step, const BodyIncrement& increment,
                              const SystematicSensitivity& J_motion) {
  advanceSensitivity(step, J_motion, sensitivity_);
  advanceNoise(step, increment.path_covariance, segment_noise_);
  displacement_ += Complex(step.dx, step.dy);
  length_ += std::abs(increment.motion.x()) + std::abs(increment.motion.y());
  turn_ += std::abs(increment.motion.z());
  if (length_ > kSegmentLength || turn_ > kSegmentTurn) moveNodes();
}

/// e^{i delta} of the plus node.
SystematicNodes::Complex SystematicNodes::turnOf(const Opposites& nodes) const {
  const Complex turn = axes_[nodes.axis].turn[nodes.place];
  if (nodes.second_sign == 0.0) return turn;
  const Complex second = axes_[nodes.second_axis].turn[0];
  return turn * (nodes.second_sign > 0.0 ? second : std::conj(second));
}

void SystematicNodes::moveNodes() {
  const SystematicSensitivity change = sensitivity_ - begin_sensitivity_;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    Axis& axis = axes_[j];
    const double heading = begin_sensitivity_(2, axis.component);
    axis.w = Complex(change(0, axis.component), change(1, axis.component)) - kI * heading * displacement_;
  }
  for (std::size_t k = 0; k < count_; ++k) move(nodes_[k]);
  move(nominal_, displacement_, 1.0);
  noise_heading_ += segment_noise_(2, 2);
  for (std::size_t j = 0; j < dimensions_; ++j)
    for (std::size_t i = 0; i < axes_[j].place.size(); ++i)
      axes_[j].turn[i] = std::polar(1.0, axes_[j].place[i] * sensitivity_(2, axes_[j].component));
  setMoments();
  beginSegment();
}

/// A node drives the segment turned by the error of its heading at the beginning, delta = phi a_k, and with
/// its own parameters: e^{i delta} (d + w a_k), where w = dd/da seen from the beginning.
void SystematicNodes::move(Opposites& nodes) {
  const Complex turn = turnOf(nodes);
  const Axis& axis = axes_[nodes.axis];
  const Axis& second = axes_[nodes.second_axis];
  const Complex own = axis.place[nodes.place] * axis.w + nodes.second_sign * second.place[0] * second.w;
  move(nodes.plus, turn * (displacement_ + own), turn);
  move(nodes.minus, std::conj(turn) * (displacement_ - own), std::conj(turn));
}

void SystematicNodes::move(Node& node, Complex displacement, Complex turn) const {
  node.position += displacement - displacement_;
  move(node.noise, displacement, turn);
}

/// (S1) in complex form: the segment carries the heading's error so far along, n += i D nu, and its own noise
/// is turned with it.
void SystematicNodes::move(NodeNoise& noise, Complex displacement, Complex turn) const {
  const Eigen::Matrix3d& S = segment_noise_;
  const Complex lever = kI * displacement;
  noise.norm += 2.0 * (std::conj(lever) * noise.heading).real() + std::norm(displacement) * noise_heading_ +
                S(0, 0) + S(1, 1);
  noise.square += lever * (2.0 * noise.heading + lever * noise_heading_) +
                  turn * turn * Complex(S(0, 0) - S(1, 1), 2.0 * S(0, 1));
  noise.heading += lever * noise_heading_ + turn * Complex(S(0, 2), S(1, 2));
}

void SystematicNodes::Moments::add(const Opposites& nodes, Complex turn, const NodeNoise& nominal) {
  const double weight = nodes.weight;
  const Complex plus = nodes.plus.position;
  const Complex minus = nodes.minus.position;
  const Complex sum = weight * (plus + minus);
  mean += sum;
  norm += weight * (std::norm(plus) + std::norm(minus));
  square += weight * (plus * plus + minus * minus);
  backward += weight * (plus * std::conj(turn) + minus * turn);
  forward += weight * (plus * turn + minus * std::conj(turn));
  turn_mean += 2.0 * weight * (turn.real() - 1.0);
  turn_square += 2.0 * weight * ((turn * turn).real() - 1.0);
  noise.norm += weight * (nodes.plus.noise.norm + nodes.minus.noise.norm - 2.0 * nominal.norm);
  noise.square += weight * (nodes.plus.noise.square + nodes.minus.noise.square - 2.0 * nominal.square);
  noise.heading += weight * (nodes.plus.noise.heading + nodes.minus.noise.heading - 2.0 * nominal.heading);
}

/// The linear part goes to the sensitivity, so that it is carried on from step to step.
void SystematicNodes::setMoments() {
  moments_ = Moments();
  for (std::size_t k = 0; k < count_; ++k) {
    const Opposites& nodes = nodes_[k];
    moments_.add(nodes, turnOf(nodes), nominal_);
    const Complex difference = nodes.weight * (nodes.plus.position - nodes.minus.position);
    moments_.with_a[nodes.axis] += axes_[nodes.axis].place[nodes.place] * difference;
    moments_.with_a[nodes.second_axis] += nodes.second_sign * axes_[nodes.second_axis].place[0] * difference;
  }
  for (std::size_t j = 0; j < dimensions_; ++j) {
    sensitivity_(0, axes_[j].component) = moments_.with_a[j].real();
    sensitivity_(1, axes_[j].component) = moments_.with_a[j].imag();
  }
}

/// Since the nodes were last moved they have gone on by e^{i delta} (d + w a) - d. Of the moments of that,
/// those of e^{i delta} d are taken as they are, and w a counts in the sensitivity alone. What the errors of
/// the heading do to the noise is known to first order in the noise and fades where that order ends.
Eigen::Matrix3d SystematicNodes::beyondLinear() const {
  const Moments& m = moments_;
  const Complex d = displacement_;
  const Complex mean = lag();
  const double fade = std::exp(-2.0 * noise_heading_);
  double norm = m.norm + 2.0 * (std::conj(d) * (m.backward - m.mean)).real() +
                2.0 * (1.0 - m.turn_mean) * std::norm(d) - std::norm(mean) + fade * m.noise.norm;
  Complex square = m.square + 2.0 * d * (m.forward - m.mean) +
                   (m.turn_square - 2.0 * m.turn_mean + 1.0) * d * d - mean * mean + fade * m.noise.square;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    const Eigen::Index k = axes_[j].component;
    const Complex linear =
        Complex(begin_sensitivity_(0, k), begin_sensitivity_(1, k)) + kI * begin_sensitivity_(2, k) * d;
    norm -= std::norm(linear);
    square -= linear * linear;
  }
  const Complex heading = fade * m.noise.heading;
  Eigen::Matrix3d covariance;
  covariance << 0.5 * (norm + square.real()), 0.5 * square.imag(), heading.real(),  //
      0.5 * square.imag(), 0.5 * (norm - square.real()), heading.imag(),            //
      heading.real(), heading.imag(), 0.0;
  return covariance;
}

}  // namespace bs_car_odometry
