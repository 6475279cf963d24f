#pragma once

#include "bs_car_odometry/calibration/motion_model.hpp"
#include "bs_car_odometry/calibration/refinement.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <vector>

namespace bs_car_odometry::calibration {

/// The motion from one laser pose to the next, linear in the parameters about those it was worked out with.
struct Link {
  Pose2 motion;            ///< of base_link, seen from where it begins
  MotionSensitivity J;     ///< d motion / d parameters that move the car
  Eigen::Matrix3d noise;   ///< covariance of motion
  Eigen::Matrix3d wheels;  ///< the part of it that noise/wheel makes; zero unless asked for
  double distance{0.0};    ///< [m]
  double weight{1.0};      ///< below 1 where the motion is believed less than its noise says
};

/// One laser pose and the pose of base_link at that instant.
struct Node {
  Eigen::Vector3d pose;        ///< base_link in the map (x, y, yaw); yaw goes on from node to node
  Eigen::Vector3d measured;    ///< the laser's pose; yaw within half a turn of what `pose` lets expect
  Eigen::Matrix3d covariance;  ///< R
  BodyMotion twist;            ///< of base_link [m/s, m/s, rad/s]
  double weight{1.0};          ///< of the laser pose, below 1 where it is believed less; 0: left out
  std::size_t laser{0};        ///< its number in the drive
  bool linked{false};          ///< the motion from the node before is known
  Link link;                   ///< that motion
};

/// The laser poses of one drive and the motion between them.
struct Chain {
  std::vector<Node> nodes;
  Evidence evidence;  ///< of all its readings, about the values that the chain is about
};

struct ChainOptions {
  LaserScales laser_scales;
  std::size_t stride{1};  ///< every which laser pose is used
  bool wheel_covariance{false};
};

/// Goes through a drive with the parameters of `values`, time offset included.
/// @param parameters  those that the drive was recorded with
/// @param poses       base_link in the map for each laser pose of the drive
Chain makeChain(const CalibrationDrive& drive, const Parameters& parameters, const ParameterVector& values,
                const std::vector<Pose2>& poses, const ChainOptions& options);

/// R of a laser whose standard deviations are so many times larger.
Eigen::Matrix3d scaled(const Eigen::Matrix3d& covariance, const LaserScales& scales);

/// Measured less fitted (x, y, yaw) [m, m, rad].
Eigen::Vector3d laserResidual(const Node& node, const ParameterVector& values);

/// Motion between two fitted poses less that of the link (x, y, yaw), seen from where it begins.
Eigen::Vector3d motionResidual(const Node& from, const Node& to);

/// r^T R^-1 r.
double normalisedSquare(const Eigen::Vector3d& residual, const Eigen::Matrix3d& R);

}  // namespace bs_car_odometry::calibration
