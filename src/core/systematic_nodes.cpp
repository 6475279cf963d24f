#include "bs_car_odometry/core/systematic_nodes.hpp"

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
  reset();
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

void SystematicNodes::reset() {
  sensitivity_.setZero();
  for (Axis& axis : axes_) axis.turn.fill(1.0);
  for (Opposites& nodes : nodes_) nodes.plus = nodes.minus = 0.0;
  setMoments();
  beginSegment();
}

void SystematicNodes::reset(const SystematicSensitivity& sensitivity) {
  sensitivity_ = sensitivity;
  Row moved{};
  for (std::size_t j = 0; j < dimensions_; ++j)
    moved[j] = Complex(sensitivity(0, axes_[j].component), sensitivity(1, axes_[j].component));
  for (std::size_t k = 0; k < count_; ++k) {
    nodes_[k].plus = displacement(nodes_[k], moved);
    nodes_[k].minus = -nodes_[k].plus;
  }
  setTurns();
  setMoments();
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

/// e^{i delta} of the plus node.
SystematicNodes::Complex SystematicNodes::turnOf(const Opposites& nodes) const {
  const Complex turn = axes_[nodes.axis].turn[nodes.place];
  if (nodes.second_sign == 0.0) return turn;
  const Complex second = axes_[nodes.second_axis].turn[0];
  return turn * (nodes.second_sign > 0.0 ? second : std::conj(second));
}

/// w = dd/da seen from the beginning: what Phi has gained less what the heading's error there has done.
SystematicNodes::Segment SystematicNodes::segment() const {
  Segment segment;
  segment.d = displacement_;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    const Eigen::Index k = axes_[j].component;
    segment.phi[j] = begin_sensitivity_(2, k);
    segment.w[j] = Complex(sensitivity_(0, k) - begin_sensitivity_(0, k),
                           sensitivity_(1, k) - begin_sensitivity_(1, k)) -
                   kI * segment.phi[j] * displacement_;
  }
  return segment;
}

/// What the plus node makes of a sensitivity to the components of a.
SystematicNodes::Complex SystematicNodes::displacement(const Opposites& nodes, const Row& sensitivity) const {
  return axes_[nodes.axis].place[nodes.place] * sensitivity[nodes.axis] +
         nodes.second_sign * axes_[nodes.second_axis].place[0] * sensitivity[nodes.second_axis];
}

void SystematicNodes::moveNodes() {
  const Segment s = segment();
  for (std::size_t k = 0; k < count_; ++k) {
    Opposites& nodes = nodes_[k];
    const Complex turn = turnOf(nodes);
    const Complex own = displacement(nodes, s.w);
    nodes.plus += turn * (s.d + own) - s.d;
    nodes.minus += std::conj(turn) * (s.d - own) - s.d;
  }
  setTurns();
  setMoments();
  beginSegment();
}

void SystematicNodes::setTurns() {
  for (std::size_t j = 0; j < dimensions_; ++j)
    for (std::size_t i = 0; i < axes_[j].place.size(); ++i)
      axes_[j].turn[i] = std::polar(1.0, axes_[j].place[i] * sensitivity_(2, axes_[j].component));
}

void SystematicNodes::Moments::add(const Opposites& nodes, Complex e) {
  const double weight = nodes.weight;
  mean += weight * (nodes.plus + nodes.minus);
  norm += weight * (std::norm(nodes.plus) + std::norm(nodes.minus));
  square += weight * (nodes.plus * nodes.plus + nodes.minus * nodes.minus);
  backward += weight * (nodes.plus * std::conj(e) + nodes.minus * e);
  forward += weight * (nodes.plus * e + nodes.minus * std::conj(e));
  turn += 2.0 * weight * (e.real() - 1.0);
  turn_twice += 2.0 * weight * ((e * e).real() - 1.0);
}

void SystematicNodes::Moments::addWithComponent(std::size_t j, double place, const Opposites& nodes,
                                                Complex e) {
  const double weight = nodes.weight * place;
  with_a[j] += weight * (nodes.plus - nodes.minus);
  backward_with_a[j] += weight * (nodes.plus * std::conj(e) - nodes.minus * e);
  forward_with_a[j] += weight * (nodes.plus * e - nodes.minus * std::conj(e));
  turn_with_a[j] += 2.0 * weight * e.imag();
  turn_twice_with_a[j] += 2.0 * weight * (e * e).imag();
}

void SystematicNodes::setMoments() {
  moments_ = Moments();
  for (std::size_t k = 0; k < count_; ++k) {
    const Opposites& nodes = nodes_[k];
    const Complex turn = turnOf(nodes);
    moments_.add(nodes, turn);
    moments_.addWithComponent(nodes.axis, axes_[nodes.axis].place[nodes.place], nodes, turn);
    if (nodes.second_sign != 0.0)
      moments_.addWithComponent(nodes.second_axis, nodes.second_sign * axes_[nodes.second_axis].place[0],
                                nodes, turn);
  }
}

// Since the nodes were last moved, dz' = dz + e^{i delta} (d + w a) - d. Moments of e^{i delta} with two
// components of a, which only meet the small w twice or the heading, are those of a Gaussian.

SystematicNodes::Complex SystematicNodes::lag(const Segment& s) const {
  Complex sum = moments_.mean + (moments_.turn - 1.0) * s.d;
  for (std::size_t j = 0; j < dimensions_; ++j) sum += kI * moments_.turn_with_a[j] * s.w[j];
  return sum;
}

double SystematicNodes::norm(const Segment& s) const {
  const Moments& m = moments_;
  const Complex d = std::conj(s.d);
  double sum = m.norm + 2.0 * (d * (m.backward - m.mean)).real() + 2.0 * (1.0 - m.turn) * std::norm(s.d);
  for (std::size_t j = 0; j < dimensions_; ++j)
    sum += 2.0 * (std::conj(s.w[j]) * m.backward_with_a[j] - d * kI * m.turn_with_a[j] * s.w[j]).real() +
           std::norm(s.w[j]);
  return sum;
}

SystematicNodes::Complex SystematicNodes::square(const Segment& s) const {
  const Moments& m = moments_;
  const Complex d = s.d;
  Complex sum = m.square + 2.0 * d * (m.forward - m.mean) + (m.turn_twice - 2.0 * m.turn + 1.0) * d * d;
  Complex along_heading;  // w phi
  for (std::size_t j = 0; j < dimensions_; ++j) {
    sum += 2.0 * s.w[j] * (m.forward_with_a[j] + kI * d * (m.turn_twice_with_a[j] - m.turn_with_a[j])) +
           m.turn_twice * s.w[j] * s.w[j];
    along_heading += s.phi[j] * s.w[j];
  }
  return sum - 4.0 * m.turn_twice * along_heading * along_heading;
}

/// E[dz' delta'], delta' with the heading's sensitivity of now.
SystematicNodes::Complex SystematicNodes::withHeading(const Segment& s) const {
  Complex sum;
  Complex along_heading;
  double phi_squared = 0.0;
  for (std::size_t j = 0; j < dimensions_; ++j) {
    const double phi = sensitivity_(2, axes_[j].component);
    sum += phi * (moments_.with_a[j] + kI * moments_.turn_with_a[j] * s.d + moments_.turn * s.w[j]);
    along_heading += s.phi[j] * s.w[j];
    phi_squared += s.phi[j] * phi;
  }
  return sum - moments_.turn * phi_squared * along_heading;
}

std::complex<double> SystematicNodes::lag() const { return lag(segment()); }

Eigen::Matrix3d SystematicNodes::secondMoment() const {
  const Segment s = segment();
  const double trace = norm(s);
  const Complex difference = square(s);
  const Complex heading = withHeading(s);
  Eigen::Matrix3d moment;
  moment << 0.5 * (trace + difference.real()), 0.5 * difference.imag(), heading.real(),  //
      0.5 * difference.imag(), 0.5 * (trace - difference.real()), heading.imag(),        //
      heading.real(), heading.imag(), sensitivity_.row(2).squaredNorm();
  return moment;
}

}  // namespace bs_car_odometry
