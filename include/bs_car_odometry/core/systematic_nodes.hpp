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
/// only positions are carried. Nodes move once in a few decimetres, and their moments are carried on in
/// between. Plane vectors are complex numbers, in odom; deviations are from the dead-reckoned pose.
class SystematicNodes {
 public:
  explicit SystematicNodes(const SystematicPrior& prior);

  /// Begins again: every node at the dead-reckoned pose.
  void reset();

  /// The same where errors have moved the pose already: by Phi a, to first order.
  void reset(const SystematicSensitivity& sensitivity);

  const SystematicSensitivity& sensitivity() const { return sensitivity_; }

  /// @param motion    t of the step [m, m, rad]
  /// @param J_motion  dt/da
  void advance(const PoseStep& step, const BodyMotion& motion, const SystematicSensitivity& J_motion);

  /// Mean deviation of the position [m].
  std::complex<double> lag() const;

  /// E[e e^T] of the deviations e = (x, y, yaw) [m, m, rad].
  Eigen::Matrix3d secondMoment() const;

 private:
  using Complex = std::complex<double>;
  using Row = std::array<Complex, systematic::kCount>;

  /// Two nodes that lie opposite to each other: one component of a, or two, at plus and minus their places.
  struct Opposites {
    double weight{0.0};  ///< of each of the two
    std::size_t axis{0};
    std::size_t place{0};        ///< which of the axis' places
    std::size_t second_axis{0};  ///< at its first place,
    double second_sign{0.0};     ///< and on this side; 0: there is none
    Complex plus;                ///< deviation of the position
    Complex minus;
  };

  /// One component of a.
  struct Axis {
    Eigen::Index component{0};
    std::array<double, 3> place{};  ///< that of the pairs, and two of a Gauss rule
    std::array<Complex, 3> turn;    ///< e^{i delta} there, delta = phi a being the error of the heading
  };

  /// Weighted sums over the nodes when they last moved: moments of dz, delta and a.
  struct Moments {
    Complex mean;                                                ///< E[dz]
    double norm{0.0};                                            ///< E|dz|^2
    Complex square;                                              ///< E[dz^2]
    Complex backward;                                            ///< E[dz e^{-i delta}]
    Complex forward;                                             ///< E[dz e^{+i delta}]
    double turn{1.0};                                            ///< E[e^{i delta}]
    double turn_twice{1.0};                                      ///< E[e^{2 i delta}]
    Row with_a{};                                                ///< E[dz a_j]
    Row backward_with_a{};                                       ///< E[dz e^{-i delta} a_j]
    Row forward_with_a{};                                        ///< E[dz e^{+i delta} a_j]
    std::array<double, systematic::kCount> turn_with_a{};        ///< Im E[e^{i delta} a_j]
    std::array<double, systematic::kCount> turn_twice_with_a{};  ///< Im E[e^{2 i delta} a_j]

    void add(const Opposites& nodes, Complex turn);
    void addWithComponent(std::size_t j, double place, const Opposites& nodes, Complex turn);
  };

  /// The stretch since the nodes last moved: a car drives e^{i delta} (d + w a), delta from its beginning.
  struct Segment {
    Complex d;
    Row w{};
    std::array<double, systematic::kCount> phi{};  ///< of the heading, at its beginning
  };

  static constexpr std::size_t kMostOpposites = std::size_t{systematic::kCount} * (systematic::kCount + 2);

  void addAxis(Eigen::Index component, const Distribution& shape);
  void addPairs(std::size_t axis);
  Segment segment() const;
  Complex displacement(const Opposites& nodes, const Row& sensitivity) const;
  void moveNodes();
  void setTurns();
  void setMoments();
  void beginSegment();
  Complex turnOf(const Opposites& nodes) const;
  Complex lag(const Segment& segment) const;
  double norm(const Segment& segment) const;
  Complex square(const Segment& segment) const;
  Complex withHeading(const Segment& segment) const;

  std::array<Axis, systematic::kCount> axes_;
  std::size_t dimensions_{0};
  std::array<Opposites, kMostOpposites> nodes_;
  std::size_t count_{0};  ///< of those in use
  Moments moments_;

  SystematicSensitivity sensitivity_;  ///< Phi
  // Since the nodes were last moved:
  Complex displacement_;  ///< of the dead-reckoned position
  double length_{0.0};    ///< of the path [m]
  double turn_{0.0};      ///< sum of the heading increments' sizes [rad]
  SystematicSensitivity begin_sensitivity_;
};

}  // namespace bs_car_odometry
