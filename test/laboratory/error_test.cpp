#include "bs_car_odometry/laboratory/error.hpp"

#include "bs_car_odometry/core/se2.hpp"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <cmath>

namespace bs_car_odometry::laboratory {
namespace {

simulation::Pose asTruth(const Pose2& pose) { return {pose.x, pose.y, pose.yaw}; }

OdometryEstimate estimateAt(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  OdometryEstimate estimate;
  estimate.pose = pose;
  estimate.pose_covariance = covariance;
  return estimate;
}

Eigen::Matrix3d someCovariance() {
  Eigen::Matrix3d covariance;
  covariance << 0.04, 0.01, 0.005, 0.01, 0.09, -0.003, 0.005, -0.003, 0.01;
  return covariance;
}

TEST(NormalisedSquare, isTheMahalanobisDistance) {
  const Eigen::Vector3d error(0.1, -0.2, 0.05);
  EXPECT_NEAR(normalisedSquare(error, someCovariance()), error.dot(someCovariance().inverse() * error),
              1e-12);
}

/// A direction that is known to a micrometre beside one known to a metre costs no digits.
TEST(NormalisedSquare, scalesMayDiffer) {
  const Eigen::Vector3d error(1.0, 2e-6, 0.03);
  const Eigen::Matrix3d covariance = Eigen::Vector3d(1.0, 1e-12, 1e-4).asDiagonal();
  EXPECT_NEAR(normalisedSquare(error, covariance), 1.0 + 4.0 + 9.0, 1e-12);
}

TEST(NormalisedSquare, anErrorWithoutUncertaintyIsInfinite) {
  const Eigen::Matrix3d covariance = Eigen::Vector3d(1.0, 0.0, 1.0).asDiagonal();
  EXPECT_TRUE(std::isinf(normalisedSquare({0.0, 0.1, 0.0}, covariance)));
}

TEST(PoseError, yawIsWrapped) {
  const Eigen::Vector3d error = poseError(estimateAt({1.0, 2.0, 3.0}, someCovariance()), {0.5, 2.5, -3.0});
  EXPECT_NEAR(error.x(), 0.5, 1e-15);
  EXPECT_NEAR(error.y(), -0.5, 1e-15);
  EXPECT_NEAR(error.z(), 6.0 - 2.0 * M_PI, 1e-15);
}

/// The truth at exp(xi) from the estimate: (N1) is xi in units of its covariance, turned into the body.
TEST(ExponentialNees, isThatOfTheExponentialCoordinates) {
  const BodyMotion xi(0.3, -0.1, 0.4);
  const Pose2 pose{1.0, -2.0, 2.8};  // the truth is across +/-pi
  Pose2 truth = pose * exp(xi);
  truth.yaw -= 2.0 * M_PI;
  const double c = std::cos(pose.yaw);
  const double s = std::sin(pose.yaw);
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // body to odom
  R.topLeftCorner<2, 2>() << c, -s, s, c;
  const OdometryEstimate estimate = estimateAt(pose, R * someCovariance() * R.transpose());
  EXPECT_NEAR(exponentialNees(estimate, asTruth(truth)), xi.dot(someCovariance().inverse() * xi), 1e-12);
}

/// In (x, y, yaw) and in exponential coordinates alike as long as the error is small.
TEST(PlainNees, agreesForSmallErrors) {
  const Pose2 pose{1.0, -2.0, 0.7};
  const OdometryEstimate estimate = estimateAt(pose, 1e-8 * someCovariance());
  const Pose2 truth = pose * exp(1e-4 * BodyMotion(0.3, -0.1, 0.2));
  const double plain = plainNees(estimate, asTruth(truth));
  EXPECT_NEAR(plain, exponentialNees(estimate, asTruth(truth)), 1e-4 * plain);
}

TEST(MeanTwist, takesOnePoseToTheOther) {
  const Eigen::Vector3d twist(2.0, -0.1, 0.6);
  const Pose2 from{3.0, 4.0, 1.0};
  const Pose2 to = from * exp(0.02 * twist);
  EXPECT_TRUE(meanTwist(asTruth(from), asTruth(to), 0.02).isApprox(twist, 1e-9));
}

}  // namespace
}  // namespace bs_car_odometry::laboratory
