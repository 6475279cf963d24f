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
/// sensitivity Phi serves.
class SystematicNodes {
 public:
  explicit SystematicNodes(const SystematicPrior& prior);

  /// Begins again: every node at the dead-reckoned pose.
  void reset();

  /// @param motion    t of the step [m, m, rad]
  /// @param J_motion  dt/da
  void advance(const PoseStep& step, const BodyMotion& motion, const SystematicSensitivity& J_motion);

  /// E[(x, y, yaw) a^T].
  const SystematicSensitivity& sensitivity() const { return sensitivity_; }

  /// Covariance of the position due to the parameters, beyond that of sensitivity() [m^2].
  Eigen::Matrix2d curvature() const;

  /// Mean of the position from the dead-reckoned one, in odom [m].
  std::complex<double> lag() const { return mean_ + (turn_mean_ - 1.0) * displacement_; }

 private:
  using Complex = std::complex<double>;
  struct Sums;

  static constexpr std::size_t kPairs = systematic::kCount * (systematic::kCount - 1) / 2;

  /// The nodes of one component alone: plus and minus each place.
  struct Axis {
    Eigen::Index component{0};       ///< of a
    std::array<double, 3> place{};   ///< that of the pairs, and two of a Gauss rule
    std::array<double, 3> weight{};  ///< of each of the two nodes there
    std::array<Complex, 3> turn;     ///< e^{i delta} of the plus node
    std::array<Complex, 3> plus;     ///< positions, see below
    std::array<Complex, 3> minus;
    Complex w;  ///< of the segment that is being moved
  };

  void addAxis(Eigen::Index component, const Distribution& shape);
  void moveNodes();
  void moveAxis(Axis& axis);
  void movePairs();
  Sums weightedSums() const;
  void setMoments(const Sums& sums);
  void beginSegment();

  // Positions of the nodes are counted from the dead-reckoned one, in odom [m]; that of a = 0 stays there.
  std::array<Axis, systematic::kCount> axes_;
  std::size_t dimensions_{0};                              ///< components of a that the rule is over
  std::array<std::array<Complex, 4>, kPairs> pair_nodes_;  ///< +-e_j +-e_l

  SystematicSensitivity sensitivity_;

  // Moments when the nodes last moved, of their positions dz and the errors delta = phi a of their headings:
  Complex mean_;             ///< E[dz]
  double norm_{0.0};         ///< E|dz|^2
  Complex square_;           ///< E[dz^2]
  Complex backward_;         ///< E[dz e^{-i delta}]
  Complex forward_;          ///< E[dz e^{+i delta}]
  double turn_mean_{1.0};    ///< E[e^{i delta}]
  double turn_square_{1.0};  ///< E[e^{2 i delta}]

  // Since the nodes were last moved:
  Complex displacement_;  ///< of the dead-reckoned position, in odom [m]
  double length_{0.0};    ///< of the path [m]
  double turn_{0.0};      ///< sum of the heading increments' sizes [rad]
  SystematicSensitivity begin_sensitivity_;
};

}  // namespace bs_car_odometry
