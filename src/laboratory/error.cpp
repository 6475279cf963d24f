#include "bs_car_odometry/laboratory/error.hpp"

#include "bs_car_odometry/core/se2.hpp"

#include <Eigen/Cholesky>

#include <cmath>
#include <limits>

namespace bs_car_odometry::laboratory {

namespace {

Pose2 asPose2(const simulation::Pose& pose) { return {pose.x, pose.y, pose.yaw}; }

}  // namespace

Eigen::Vector3d poseError(const OdometryEstimate& estimate, const simulation::Pose& truth) {
  return {estimate.pose.x - truth.x, estimate.pose.y - truth.y, wrapAngle(estimate.pose.yaw - truth.yaw)};
}

double normalisedSquare(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  // Scaled to unit variances first: metres and radians differ by orders of magnitude.
  const Eigen::Vector3d sigma = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  if (!(sigma.minCoeff() > 0.0)) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d e = error.cwiseQuotient(sigma);
  const Eigen::LDLT<Eigen::Matrix3d> correlation(covariance.cwiseQuotient(sigma * sigma.transpose()));
  if (!(correlation.vectorD().minCoeff() > 0.0)) return std::numeric_limits<double>::infinity();
  return e.dot(correlation.solve(e));
}

double exponentialNees(const Pose2& estimate, const Eigen::Matrix3d& covariance, const Pose2& truth) {
  Pose2 to_truth = inverse(estimate) * truth;
  to_truth.yaw = wrapAngle(to_truth.yaw);
  const double c = std::cos(estimate.yaw);
  const double s = std::sin(estimate.yaw);
  Eigen::Matrix3d Q = Eigen::Matrix3d::Identity();
  Q.topLeftCorner<2, 2>() << c, s, -s, c;
  return normalisedSquare(log(to_truth), Q * covariance * Q.transpose());
}

double exponentialNees(const OdometryEstimate& estimate, const simulation::Pose& truth) {
  return exponentialNees(estimate.pose, estimate.pose_covariance, asPose2(truth));
}

double plainNees(const OdometryEstimate& estimate, const simulation::Pose& truth) {
  return normalisedSquare(poseError(estimate, truth), estimate.pose_covariance);
}

Eigen::Vector3d meanTwist(const simulation::Pose& from, const simulation::Pose& to, double interval) {
  return log(inverse(asPose2(from)) * asPose2(to)) / interval;
}

}  // namespace bs_car_odometry::laboratory
