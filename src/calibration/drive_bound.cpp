#include "bs_car_odometry/calibration/drive_bound.hpp"

#include "bs_car_odometry/calibration/planar.hpp"

namespace bs_car_odometry::calibration {

namespace {

std::vector<std::size_t> indicesOf(const ParameterMask& mask) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (mask[i]) indices.push_back(i);
  return indices;
}

Eigen::VectorXd valuesAt(const std::vector<std::size_t>& indices, const ParameterVector& values) {
  Eigen::VectorXd chosen(static_cast<Eigen::Index>(indices.size()));
  for (std::size_t k = 0; k < indices.size(); ++k)
    chosen(static_cast<Eigen::Index>(k)) = values(static_cast<Eigen::Index>(indices[k]));
  return chosen;
}

}  // namespace

DriveBound::DriveBound(const Parameters& truth, const ParameterMask& estimated, const ParameterVector& prior)
    : model_(truth),
      mount_(truth.laser),
      estimated_(indicesOf(estimated)),
      bound_(valuesAt(indicesOf(estimated), prior)) {}

void DriveBound::move(const MeasuredStep& step) { model_.extend(step, segment_); }

CramerRaoBound::PoseSensitivity DriveBound::selected(const Eigen::Matrix<double, 3, kCount>& J) const {
  CramerRaoBound::PoseSensitivity columns(3, static_cast<Eigen::Index>(estimated_.size()));
  for (std::size_t k = 0; k < estimated_.size(); ++k)
    columns.col(static_cast<Eigen::Index>(k)) = J.col(static_cast<Eigen::Index>(estimated_[k]));
  return columns;
}

Eigen::MatrixXd DriveBound::selected(
    const Eigen::Matrix<double, kMotionCount, kMotionCount>& information) const {
  const auto n = static_cast<Eigen::Index>(estimated_.size());
  Eigen::MatrixXd chosen = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t i = 0; i < estimated_.size(); ++i)
    for (std::size_t j = 0; j < estimated_.size(); ++j)
      if (estimated_[i] < kMotionCount && estimated_[j] < kMotionCount)
        chosen(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            information(static_cast<Eigen::Index>(estimated_[i]), static_cast<Eigen::Index>(estimated_[j]));
  return chosen;
}

void DriveBound::predict() {
  const Eigen::Matrix3d turned = rotation(pose_.yaw);
  const Pose2 next = pose_ * segment_.motion;
  const Eigen::Matrix3d F = leverArm(next.position() - pose_.position());
  Eigen::Matrix<double, 3, kCount> J = Eigen::Matrix<double, 3, kCount>::Zero();
  J.leftCols<kMotionCount>() = turned * segment_.J;
  bound_.predict(F, selected(J), turned * segment_.covariance() * turned.transpose());
  bound_.add(selected(segment_.evidence.information));
  pose_ = next;
}

void DriveBound::update(const Eigen::Matrix3d& R) {
  const BodyMotion twist = segment_.twist;
  predict();
  segment_ = segment_.next();
  segment_.twist = twist;  // for a laser pose without a step since the one before
  const Eigen::Matrix3d turned = rotation(pose_.yaw);
  const Eigen::Matrix3d H_pose = leverArm(turned.topLeftCorner<2, 2>() * Eigen::Vector2d(mount_.x, mount_.y));
  Eigen::Matrix<double, 3, kCount> H = Eigen::Matrix<double, 3, kCount>::Zero();
  H.block<3, 3>(0, kLaserX) = turned;
  H.col(kTimeOffset) = -H_pose * turned * twist;
  bound_.update(H_pose, selected(H), R);
}

void DriveBound::newDrive() {
  const auto n = static_cast<Eigen::Index>(estimated_.size());
  bound_.predict(Eigen::Matrix3d::Identity(), CramerRaoBound::PoseSensitivity::Zero(3, n),
                 kDiffuse * kDiffuse * Eigen::Matrix3d::Identity());
  segment_ = MotionSegment();
}

ParameterMatrix DriveBound::covariance() const {
  const Eigen::MatrixXd found = bound_.covariance();
  ParameterMatrix covariance = ParameterMatrix::Zero();
  for (std::size_t i = 0; i < estimated_.size(); ++i)
    for (std::size_t j = 0; j < estimated_.size(); ++j)
      covariance(static_cast<Eigen::Index>(estimated_[i]), static_cast<Eigen::Index>(estimated_[j])) =
          found(static_cast<Eigen::Index>(3 + i), static_cast<Eigen::Index>(3 + j));
  return covariance;
}

ParameterVector DriveBound::deviations() const {
  const Eigen::VectorXd found = bound_.deviations();
  ParameterVector deviations = ParameterVector::Zero();
  for (std::size_t k = 0; k < estimated_.size(); ++k)
    deviations(static_cast<Eigen::Index>(estimated_[k])) = found(static_cast<Eigen::Index>(k));
  return deviations;
}

}  // namespace bs_car_odometry::calibration
