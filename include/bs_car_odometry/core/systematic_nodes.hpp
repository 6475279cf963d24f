#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/se2.hpp"
#include "bs_car_odometry/core/systematic_prior.hpp"

#include <Eigen/Core>

#include <array>
#include <complex>

namespace bs_car_odometry {

/// What constant errors of the parameters do to the pose, beyond first order (docs/model.md, S5): a
/// deterministic rule that gets every moment of a up to the fifth degree right drives one car for each of its
/// nodes a_k. The heading of a node is linear in a, so only positions are carried. Nodes move once in a few
/// decimetres; in between, and for what is linear, the sensitivity Phi serves.
class SystematicNodes {
 public:
  explicit SystematicNodes(const SystematicPrior& prior);

  /// Begins again: every node at the dead-reckoned pose.
  void reset();

  /// @param motion    t of the step [m, m, rad]
  /// @param J_motion  dt/da
  void advance(const PoseStep& step, const BodyMotion& motion, const SystematicSensitivity& J_motion);

  /// Covariance of (x, y, yaw) due to the parameters, beyond that of sensitivity().
  const Eigen::Matrix3d& curvature() const { return curvature_; }

  /// E[(x, y, yaw) a^T].
  const SystematicSensitivity& sensitivity() const { return sensitivity_; }

 private:
  using Complex = std::complex<double>;
  using Row = std::array<Complex, systematic::kCount>;
  struct Sums;

  static constexpr std::size_t kPairs = systematic::kCount * (systematic::kCount - 1) / 2;

  void moveNodes();
  void moveAxes(const Row& turn, const Row& reach, Sums& sums);
  void movePairs(const Row& turn, const Row& reach, Sums& sums);
  void setMoments(const Sums& sums);
  void beginSegment();
  Complex positionSensitivity(std::size_t j) const;

  std::array<Eigen::Index, systematic::kCount> active_{};  ///< components of a that the rule is over
  std::size_t dimensions_{0};
  std::array<double, systematic::kCount> root_kurtosis_{};  ///< where the nodes of a component lie
  std::array<double, systematic::kCount> axis_weight_{};

  SystematicSensitivity sensitivity_;
  Eigen::Matrix3d curvature_;
  // Positions of the nodes, from the dead-reckoned one, in odom [m]; that of a = 0 stays where it is.
  std::array<std::array<Complex, 2>, systematic::kCount> axis_nodes_;  ///< +-e_j
  std::array<std::array<Complex, 4>, kPairs> pair_nodes_;              ///< +-e_j +-e_l

  // Since the nodes were last moved:
  Complex displacement_;  ///< of the dead-reckoned position, in odom [m]
  double length_{0.0};    ///< of the path [m]
  double turn_{0.0};      ///< sum of the heading increments' sizes [rad]
  SystematicSensitivity begin_sensitivity_;
};

}  // namespace bs_car_odometry
