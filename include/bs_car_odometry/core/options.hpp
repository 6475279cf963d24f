#pragma once

#include "bs_car_odometry/core/distribution.hpp"
#include "bs_car_odometry/core/time.hpp"

#include <Eigen/Core>

namespace bs_car_odometry {

/// Which wheels the odometry uses.
enum class AxleSelection {
  kBoth,   ///< all wheels and both angles, weighted least squares (docs/model.md, section 6)
  kFront,  ///< the front axle's two wheels (section 3, the papers' odometry)
  kRear,   ///< the rear axle's two wheels
};

enum class Motion {
  kExact,  ///< exact arc with the mean steering angle, (M-arc) and (M-exp)
  kPaper,  ///< P1 (2) as printed: model A, the angle at the end of the step, first order (M-1)
};

/// How the pose covariance is propagated (docs/model.md, section 5).
enum class Uncertainty {
  kFirstOrder,        ///< (S1)
  kExactMoments,      ///< (S4')
  kClosedForm,        ///< (S3), P2's general method
  kPaper2Simplified,  ///< (S2), for reproduction only
  kMonteCarlo,        ///< (5'), particles
};

/// How the moments of p(A) reach the pose with exact moments.
enum class SystematicRule {
  kDegreeFive,   ///< (S5)
  kSensitivity,  ///< Phi Sigma_A Phi^T
};

/// The particles of Uncertainty::kMonteCarlo.
struct ParticleOptions {
  int count{10000};
  int seed{1};
  int published{500};  ///< at most so many for display
  int threads{1};
};

struct OdometryOptions {
  AxleSelection axles{AxleSelection::kBoth};
  Motion motion{Motion::kExact};
  bool shortened_track{true};  ///< false: B instead of B cos(alpha), P1's trace "Odometry 2"
  Uncertainty uncertainty{Uncertainty::kFirstOrder};
  bool fault_detection{true};  ///< leave out sensors that contradict the others, with both axles
  SystematicRule systematic_rule{SystematicRule::kDegreeFive};
  ParticleOptions particles;
};

/// Errors of the steering angle: fresh after a length, so that the message rate does not matter.
struct SteeringNoise {
  Distribution angle{0.003};       ///< [rad]
  double correlation_length{0.1};  ///< [m]
};

/// p(A): errors that stay the same for the whole drive, each axle with its own draw.
struct SystematicNoise {
  Distribution k_r{0.01};
  Distribution k_l{0.01};
  Distribution k_b{0.02};
  Distribution steering_offset{0.003};  ///< [rad]
};

/// Uncertainty of the readings (docs/model.md, section 5.1).
struct NoiseModel {
  Distribution wheel{0.005};  ///< c [m/sqrt(m)], of a wheel's measured path after one metre
  SteeringNoise steering;
  Distribution lateral{0.0005};  ///< [m/sqrt(m)], side slip of an axle after one metre
  Distribution rear_law{0.001};  ///< [rad], departure from phi_rear = f(phi_front), same correlation length
  SystematicNoise systematic;
};

/// What is believed of a reading before it is used (docs/reliability.md).
struct InputLimits {
  double max_speed{40.0};                               ///< [m/s]
  Duration max_gap{durationFromSeconds(0.5)};           ///< longer intervals are counted as gaps
  Duration max_future{durationFromSeconds(0.1)};        ///< stamps further ahead of the clock are dropped
  double steering_limit{1.3};                           ///< [rad], of an axle's angle
  Duration max_steering_age{durationFromSeconds(0.2)};  ///< older angles are no longer trusted
  Duration steering_wait{durationFromSeconds(0.02)};    ///< wheels wait so long for a newer angle
};

/// What is kept to answer for the motion between two stamps (docs/model.md, 5.8).
struct RelativeMotionOptions {
  Duration history{durationFromSeconds(60.0)};  ///< how far back; zero keeps nothing
};

/// Pose of base_link in odom at the start.
struct InitialPose {
  double x{0.0};                                        ///< [m]
  double y{0.0};                                        ///< [m]
  double yaw{0.0};                                      ///< [rad]
  Eigen::Matrix3d covariance{Eigen::Matrix3d::Zero()};  ///< (x, y, yaw)
};

}  // namespace bs_car_odometry
