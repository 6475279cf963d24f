#include "path_information.hpp"

#include <Eigen/Cholesky>

#include <cmath>

namespace bs_car_odometry::calibration {

namespace {

Eigen::Vector2d turned(const Eigen::Vector2d& point) { return {-point.y(), point.x()}; }

/// What later points of a part make of an error of the pose (x, y, yaw) here: sums of J^T R^-1 over them.
class LaterPoints {
 public:
  using Weights = Eigen::Matrix<double, kCount, 2>;

  /// @param centre  near the path, so that no digits are lost far from the map's origin
  explicit LaterPoints(const Eigen::Vector2d& centre) : centre_(centre) { clear(); }

  void clear() {
    shift_.setZero();
    turn_.setZero();
  }

  void add(const Weights& weights, const Eigen::Vector2d& point) {
    shift_ += weights;
    turn_ += weights * turned(point - centre_);
  }

  /// @param pivot  what the error of the yaw turns the rest of the path about
  Eigen::Matrix<double, kCount, 3> influence(const Eigen::Vector2d& pivot) const {
    Eigen::Matrix<double, kCount, 3> influence;
    influence << shift_, turn_ - shift_ * turned(pivot - centre_);
    return influence;
  }

 private:
  Eigen::Vector2d centre_;
  Weights shift_;
  ParameterVector turn_;
};

/// Columns of those that are in the mask.
Eigen::MatrixXd selection(const ParameterMask& mask) {
  Eigen::MatrixXd columns(kCount, 0);
  for (std::size_t i = 0; i < kCount; ++i) {
    if (!mask[i]) continue;
    columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
    columns.rightCols<1>() = ParameterVector::Unit(static_cast<Eigen::Index>(i));
  }
  return columns;
}

}  // namespace

PathInformation::PathInformation(const ParameterPrior& prior)
    : prior_(prior), normal_(ParameterMatrix::Zero()), scatter_(ParameterMatrix::Zero()) {
  for (const Eigen::Index i : prior.active) normal_(i, i) = std::pow(prior.deviation[i], -2);
  scatter_ = normal_;
}

void PathInformation::add(const Evidence& evidence) {
  normal_.topLeftCorner<kMotionCount, kMotionCount>() += evidence.information;
  scatter_.topLeftCorner<kMotionCount, kMotionCount>() += evidence.information;
}

/// From the end, so that every error meets the points that come after it.
void PathInformation::add(const std::vector<PathPoint>& path) {
  if (path.empty()) return;
  LaterPoints later(path.front().measured);
  for (auto point = path.rbegin(); point != path.rend(); ++point) {
    if (point->begins) {
      const auto influence = later.influence(point->measured);
      scatter_ += influence * point->R * influence.transpose();
      later.clear();
      continue;
    }
    if (point->trusted) {
      const Eigen::Matrix2d R = point->R.topLeftCorner<2, 2>();
      const LaterPoints::Weights weights = R.llt().solve(point->J).transpose();
      normal_ += weights * point->J;
      scatter_ += weights * R * weights.transpose();
      later.add(weights, point->reckoned);
    }
    const auto influence = later.influence(point->base.position());
    scatter_ += influence * point->noise * influence.transpose();
  }
}

ParameterMatrix PathInformation::covariance(const ParameterMask& fitted) const {
  ParameterMask kept{};
  for (std::size_t i = 0; i < kCount; ++i) kept[i] = prior_.estimated[i] && !fitted[i];
  const Eigen::MatrixXd F = selection(fitted);
  const Eigen::MatrixXd K = selection(kept);
  ParameterMatrix P = K * (K.transpose() * prior_.deviation).cwiseAbs2().asDiagonal() * K.transpose();
  if (F.cols() == 0) return P;
  // What the noise, and the errors of those that are kept, move the fitted ones by.
  const Eigen::MatrixXd N = F * (F.transpose() * normal_ * F).llt().solve(F.transpose());
  const ParameterMatrix moved = ParameterMatrix::Identity() - N * normal_;
  const ParameterMatrix sum = N * scatter_ * N.transpose() + moved * P * moved.transpose();
  return 0.5 * (sum + sum.transpose());
}

}  // namespace bs_car_odometry::calibration
