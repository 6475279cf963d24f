#include "bs_car_odometry/calibration/first_fix.hpp"

#include "bs_car_odometry/calibration/filter.hpp"

#include <Eigen/Cholesky>

namespace bs_car_odometry::calibration {

namespace {

/// True when two beginnings may be the same, as far as the laser's own noise goes.
bool agree(const Pose2& a, const Pose2& b, const Eigen::Matrix3d& covariance) {
  Eigen::Vector3d difference = a.vector() - b.vector();
  difference.z() = wrapAngle(difference.z());
  return difference.dot(covariance.llt().solve(difference)) < kRejectLimit;
}

}  // namespace

FirstFix chooseFirstFix(const std::vector<LaserPose>& lasers, const std::vector<Pose2>& beginnings) {
  FirstFix best;
  for (std::size_t i = 0; i < lasers.size(); ++i) {
    std::size_t agreeing = 0;
    for (std::size_t j = 0; j < lasers.size(); ++j)
      if (agree(beginnings[i], beginnings[j], lasers[i].covariance + lasers[j].covariance)) ++agreeing;
    if (agreeing > best.agreeing) best = {i, agreeing};
  }
  return best;
}

}  // namespace bs_car_odometry::calibration
