#include "bs_car_odometry/calibration/driven_paths.hpp"

#include "bs_car_odometry/calibration/planar.hpp"

#include <cmath>

namespace bs_car_odometry::calibration {

namespace {

constexpr double kSpacing = 0.1;  // [m], of a short drive

Pose2 poseOf(const Eigen::Vector3d& vector) { return {vector.x(), vector.y(), vector.z()}; }

}  // namespace

DrivenPaths::DrivenPaths(const Parameters& parameters) : model_(parameters), spacing_(kSpacing) {}

void DrivenPaths::start() {
  spacing_ = kSpacing;
  begin_.reset();
  segment_ = MotionSegment();
  pieces_.clear();
  laser_.clear();
}

void DrivenPaths::add(const MeasuredStep& step) {
  if (!begin_) return;
  model_.extend(step, segment_);
  if (segment_.distance < spacing_) return;
  pieces_.push_back({segment_.motion, segment_.J});
  segment_ = MotionSegment();
  if (pieces_.size() >= kMostPoses) halve();
}

void DrivenPaths::add(const CalibrationUpdate& update) {
  const ParameterVector& values = update.estimate.values;
  if (!begin_) begin_ = update.estimate.pose;
  if (!laser_.empty() && std::abs(update.distance - laser_distance_) < spacing_) return;
  laser_distance_ = update.distance;
  laser_.push_back(update.laser.pose * inverse(mountOf(values)));
  if (laser_.size() >= kMostPoses) halve();
}

DrivenPaths::Piece DrivenPaths::joined(const Piece& first, const Piece& second) {
  const double c = std::cos(first.motion.yaw);
  const double s = std::sin(first.motion.yaw);
  Piece piece{first.motion * second.motion, first.J};
  piece.J.row(0) += c * second.J.row(0) - s * second.J.row(1) -
                    (s * second.motion.x + c * second.motion.y) * first.J.row(2);
  piece.J.row(1) += s * second.J.row(0) + c * second.J.row(1) +
                    (c * second.motion.x - s * second.motion.y) * first.J.row(2);
  piece.J.row(2) += second.J.row(2);
  return piece;
}

void DrivenPaths::halve() {
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i + 1 < pieces_.size(); i += 2)
    pieces.push_back(joined(pieces_[i], pieces_[i + 1]));
  if (pieces_.size() % 2 == 1) pieces.push_back(pieces_.back());
  pieces_ = std::move(pieces);
  std::vector<Pose2> laser;
  for (std::size_t i = 0; i < laser_.size(); i += 2) laser.push_back(laser_[i]);
  laser_ = std::move(laser);
  spacing_ *= 2.0;
}

std::vector<Pose2> DrivenPaths::path(const ParameterVector& values) const {
  std::vector<Pose2> poses;
  if (!begin_) return poses;
  const Eigen::Matrix<double, kMotionCount, 1> change = (values - model_.values()).head<kMotionCount>();
  poses.reserve(pieces_.size() + 1);
  poses.push_back(*begin_);
  for (const Piece& piece : pieces_)
    poses.push_back(poses.back() * poseOf(piece.motion.vector() + piece.J * change));
  return poses;
}

}  // namespace bs_car_odometry::calibration
