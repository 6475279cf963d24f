#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/se2.hpp"
#include "bs_car_odometry/core/systematic_prior.hpp"

#include <Eigen/Core>

#include <array>
#include <complex>

namespace bs_car_odometry {

/// What constant errors of the parameters do to the pose, beyond first order (docs/model.md, S5): a
/// deterministic rule drives one car for each of its nodes a_k. It gets every moment of a up to the fifth
/// degree right, and those of each component alone up to the ninth. The heading of a node is linear in a, so
/// only positions are carried. Nodes move once in a few decimetres; in between, and for what is linear, the
/// sensitivity Phi serves. Plane vectors are complex numbers, in odom.
class SystematicNodes {
 public:
  explicit SystematicNodes(const SystematicPrior& prior);

  /// Begins again: every node at the dead-reckoned pose, which has this covariance.
  void reset(const Eigen::Matrix3d& covariance);

  void advance(const PoseStep& step, const BodyIncrement& increment, const SystematicSensitivity& J_motion);

  /// Adds an independent error of the pose.
  void inflate(const Eigen::Matrix3d& covariance);

  /// E[(x, y, yaw) a^T].
  const SystematicSensitivity& sensitivity() const { return sensitivity_; }

  /// Covariance of (x, y, yaw) due to the parameters, beyond that of sensitivity() and of the noise on the
  /// dead-reckoned path. May have negative eigenvalues.
  Eigen::Matrix3d beyondLinear() const;

  /// Mean of the position from the dead-reckoned one [m].
  std::complex<double> lag() const { return moments_.mean + (moments_.turn_mean - 1.0) * displacement_; }

 private:
  using Complex = std::complex<double>;

  /// Covariance of the noise on one node's path, to first order; that of the heading is common to all.
  struct NodeNoise {
    double norm{0.0};  ///< E|n|^2
    Complex square;    ///< E[n^2]
    Complex heading;   ///< E[n nu]
  };

  struct Node {
    Complex position;  ///< from the dead-reckoned one; that of a = 0 stays there
    NodeNoise noise;
  };

  /// Two nodes that lie opposite to each other: one component of a, or two, at plus and minus their places.
  struct Opposites {
    double weight{0.0};  ///< of each of the two
    std::size_t axis{0};
    std::size_t place{0};        ///< which of the axis' places
    std::size_t second_axis{0};  ///< at its first place,
    double second_sign{0.0};     ///< and on this side; 0: there is none
    Node plus;
    Node minus;
  };

  /// One component of a.
  struct Axis {
    Eigen::Index component{0};
    std::array<double, 3> place{};  ///< that of the pairs, and two of a Gauss rule
    std::array<Complex, 3> turn;    ///< e^{i delta} there, delta = phi a being the error of the heading
    Complex w;                      ///< dd/da of the segment that is being moved
  };

  /// Weighted sums over the nodes.
  struct Moments {
    Complex mean;                                      ///< E[dz]
    double norm{0.0};                                  ///< E|dz|^2
    Complex square;                                    ///< E[dz^2]
    Complex backward;                                  ///< E[dz e^{-i delta}]
    Complex forward;                                   ///< E[dz e^{+i delta}]
    double turn_mean{1.0};                             ///< E[e^{i delta}]
    double turn_square{1.0};                           ///< E[e^{2 i delta}]
    NodeNoise noise;                                   ///< less that of the dead-reckoned path
    std::array<Complex, systematic::kCount> with_a{};  ///< E[dz a_j]

    void add(const Opposites& nodes, Complex turn, const NodeNoise& nominal);
  };

  static constexpr std::size_t kMostOpposites = systematic::kCount * (systematic::kCount + 2);

  void addAxis(Eigen::Index component, const Distribution& shape);
  void addPairs(std::size_t axis);
  void moveNodes();
  void move(Opposites& nodes);
  void move(Node& node, Complex displacement, Complex turn) const;
  void move(NodeNoise& noise, Complex displacement, Complex turn) const;
  void setMoments();
  void beginSegment();
  Complex turnOf(const Opposites& nodes) const;

  std::array<Axis, systematic::kCount> axes_;
  std::size_t dimensions_{0};
  std::array<Opposites, kMostOpposites> nodes_;
  std::size_t count_{0};  ///< of those in use

  SystematicSensitivity sensitivity_;
  Moments moments_;            ///< when the nodes last moved, as is:
  NodeNoise nominal_;          ///< of the dead-reckoned path
  double noise_heading_{0.0};  ///< variance of the heading by noise [rad^2]

  // Since the nodes were last moved:
  Complex displacement_;           ///< d, of the dead-reckoned position
  double length_{0.0};             ///< of the path [m]
  double turn_{0.0};               ///< sum of the heading increments' sizes [rad]
  Eigen::Matrix3d segment_noise_;  ///< covariance of (x, y, yaw)
  SystematicSensitivity begin_sensitivity_;
};

}  // namespace bs_car_odometry
