#pragma once

#include "bs_car_odometry/core/odometry_configuration.hpp"
#include "bs_car_odometry/core/particle_kernels.hpp"
#include "bs_car_odometry/core/pose_uncertainty.hpp"
#include "bs_car_odometry/core/wheels_and_axles.hpp"

#include <Eigen/Core>

#include <array>
#include <cstddef>

namespace bs_car_odometry {

/// What one step is to all particles: the motion by the readings alone, and how a particle's own errors
/// change it.
struct ParticlePlan {
  /// Noise of the step that is no plain Gaussian: a draw of the distribution times the column.
  struct Source {
    const Distribution* distribution;
    Eigen::Vector3f column;
  };
  static constexpr std::size_t kMostSources = kWheels + kAxles;

  ReferenceStep reference;
  std::array<float, 3> motion;
  PerAxle<std::array<float, 9>> gains;  ///< motion over k_r, k_l, k_b of the axle, row by row
  bool has_gaussian{false};
  std::array<float, 9> gaussian;  ///< root of the covariance of all Gaussian noise, row by row
  std::array<Source, kMostSources> sources;
  std::size_t source_count{0};
  std::array<float, 15>
      angles;  ///< motion over f, f^2, r, r^2, fr of the errors f, r of the angles, row by row
  PerAxle<double> angle_path;  ///< travel of the axles [m]: how long an error of their angle is held
};

/// Makes the plans (docs/model.md, section 5.6).
class ParticlePlanner {
 public:
  explicit ParticlePlanner(const OdometryConfiguration& configuration);

  /// Distribution of the error of an axle's angle that is held for a length: of its sensor or, where the rear
  /// axle has none, of the rear law. Zero where the angle does not matter.
  const Distribution& angleError(Axle axle) const { return angle_error_[axle]; }

  /// Whether a constant error of the axle's sensor matters.
  bool hasOffset(Axle axle) const { return has_offset_[axle]; }

  /// Tells how large the constant errors of both angles are [rad].
  void setOffsets(const PerAxle<double>& std);

  ParticlePlan plan(const UncertainStep& step) const;

 private:
  void planNoise(const StepNoise& noise, ParticlePlan& plan) const;
  void planAngles(const UncertainStep& step, ParticlePlan& plan) const;
  BodyMotion motionWith(const UncertainStep& step, double front_error, double rear_error) const;

  Distribution wheel_;
  Distribution lateral_;
  RearSteering rear_steering_;
  PerAxle<Distribution> angle_error_;
  PerAxle<bool> has_offset_;
  PerAxle<double> reach_;  ///< errors of the angles at which motions are tried [rad]
};

}  // namespace bs_car_odometry
