#pragma once

#include "bs_car_odometry/core/body_increment.hpp"
#include "bs_car_odometry/core/options.hpp"
#include "bs_car_odometry/core/vehicle.hpp"

#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry {

enum class InputSource { kWheelTicks, kJointStates };
enum class StampSource { kHeader, kReceipt };

/// Joint names with `input: joint_states`; an axle is steered by one joint or by its left and right wheel.
struct JointNames {
  PerWheel<std::string> wheels;
  PerAxle<std::vector<std::string>> steering;
};

/// Where the laser's pose is measured, in base_link; or the name of that frame in tf.
struct LaserMount {
  std::string frame;
  double x{0.0};            ///< [m]
  double y{0.0};            ///< [m]
  double yaw{0.0};          ///< [rad]
  double time_offset{0.0};  ///< [s], a pose stamped t shows the car at t - time_offset
};

/// Standard deviations where `laser_pose` carries no covariance.
struct LaserSigma {
  double position{0.02};  ///< [m]
  double yaw{0.005};      ///< [rad]
};

enum class CalibrationMethod { kJoint, kPaper };

/// Standard deviations before the calibration drive.
struct CalibrationPrior {
  double k_r{0.05};
  double k_l{0.05};
  double k_b{0.05};
  double steering_offset{0.02};  ///< [rad]
  double steering_scale{0.05};
};

struct CalibrationOptions {
  CalibrationMethod method{CalibrationMethod::kJoint};
  std::vector<std::string> estimate{"gains"};
  CalibrationPrior prior;
  double gain_random_walk{0.0};  ///< [1/sqrt(m)]
  bool allow_partial{false};
  double straight_limit{0.05};  ///< [rad]
};

/// Every parameter of the package's nodes and tools; one YAML file holds them. Defaults stand here, units and
/// meaning at the fields; the allowed ranges stand in src/parameters/schema.cpp.
struct Parameters {
  std::string base_frame{"base_link"};
  std::string odom_frame{"odom"};
  bool publish_tf{true};
  InputSource input{InputSource::kWheelTicks};
  bool accept_calibration{false};
  std::string calibration_file;
  bool require_calibration{false};
  std::string output;  ///< file that the calibration writes

  Vehicle vehicle;
  JointNames joints;
  OdometryOptions odometry;
  NoiseModel noise;
  /// A calibration's, in the place of noise.systematic; comes with its file, never from the parameters.
  std::optional<SystematicCovariance> systematic_covariance;
  CalibrationOptions calibration;
  LaserMount laser;
  LaserSigma laser_sigma;
  InitialPose initial_pose;
  InputLimits limits;
  RelativeMotionOptions relative_motion;
  StampSource stamp_source{StampSource::kHeader};
  double unmeasured_variance{0.0};  ///< of z [m^2], roll and pitch [rad^2]
};

}  // namespace bs_car_odometry
