#include "bs_car_odometry/calibration/joint_filter.hpp"

#include "bs_car_odometry/calibration/planar.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>

namespace bs_car_odometry::calibration {

namespace {

/// No pose is believed to less than this share of the laser's own deviation: errors of a map and of a parked
/// car's localiser do not average out for ever.
constexpr double kPoseFloor = 0.05;

/// From base_link to the laser, in the frame of the poses [m].
Eigen::Vector2d armOf(const Pose2& base, const ParameterVector& values) {
  return rotation(base.yaw).topLeftCorner<2, 2>() * values.segment<2>(kLaserX);
}

}  // namespace

JointFilter::JointFilter(const Parameters& parameters, bool takes_out_track_noise)
    : takes_out_track_noise_(takes_out_track_noise),
      random_walk_(ParameterVector::Zero()),
      model_(parameters) {
  const ParameterMask estimated = parametersToEstimate(parameters);
  const ParameterVector deviations = priorDeviations(parameters);
  for (std::size_t i = 0; i < kCount; ++i) {
    if (!estimated[i]) continue;
    active_.push_back(i);
    if (isGain(i))
      random_walk_[static_cast<Eigen::Index>(i)] = std::pow(parameters.calibration.gain_random_walk, 2);
  }
  const auto n = static_cast<Eigen::Index>(3 + active_.size());
  state_.values = prior_ = model_.values();
  prior_variance_ = deviations.cwiseAbs2();
  state_.P = StateMatrix::Zero(n, n);
  for (std::size_t k = 0; k < active_.size(); ++k)
    state_.P.diagonal()[static_cast<Eigen::Index>(3 + k)] =
        std::pow(deviations[static_cast<Eigen::Index>(active_[k])], 2);
}

JointFilter::MeasurementJacobian JointFilter::columns(const Eigen::Matrix<double, 3, kCount>& J) const {
  MeasurementJacobian result(3, static_cast<Eigen::Index>(active_.size()));
  for (std::size_t k = 0; k < active_.size(); ++k)
    result.col(static_cast<Eigen::Index>(k)) = J.col(static_cast<Eigen::Index>(active_[k]));
  return result;
}

Eigen::Vector3d JointFilter::laserVelocity(const State& state) const {
  const BodyMotion& twist = segment_.twist;
  return rotation(state.pose.yaw) * Eigen::Vector3d(twist.x() - twist.z() * state.values[kLaserY],
                                                    twist.y() + twist.z() * state.values[kLaserX], twist.z());
}

JointFilter::MeasurementJacobian JointFilter::measurementJacobian(const State& state) const {
  Eigen::Matrix<double, 3, kCount> J = Eigen::Matrix<double, 3, kCount>::Zero();
  J.middleCols<3>(kLaserX) = rotation(state.pose.yaw);
  J.col(kTimeOffset) = -laserVelocity(state);
  MeasurementJacobian H(3, state.P.cols());
  H.leftCols<3>() = leverArm(armOf(state.pose, state.values));
  H.rightCols(static_cast<Eigen::Index>(active_.size())) = columns(J);
  return H;
}

/// The pose of base_link that the laser's pose means, with the covariance of both: whatever is not known of
/// the mount and the delay is not known of the pose, and remains tied to it.
void JointFilter::begin(const LaserPose& laser) {
  state_.pose = laser.pose * inverse(mountOf(state_.values));
  const Eigen::Matrix3d J_laser = leverArm(-armOf(state_.pose, state_.values));
  const auto n = static_cast<Eigen::Index>(active_.size());
  const MeasurementJacobian J = -J_laser * measurementJacobian(state_).rightCols(n);
  StateMatrix& P = state_.P;
  const MeasurementJacobian cross = J * P.bottomRightCorner(n, n);
  P.topLeftCorner<3, 3>() = J_laser * laser.covariance * J_laser.transpose() + cross * J.transpose();
  P.topRightCorner(3, n) = cross;
  P.bottomLeftCorner(n, 3) = cross.transpose();
  state_.track_noise = TrackNoise();
  segment_ = segment_.next();
}

Eigen::Matrix<double, kMotionCount, 1> JointFilter::offModel() const {
  return state_.values.head<kMotionCount>() - model_.values().head<kMotionCount>();
}

Pose2 JointFilter::motion() const {
  if (!elsewhere_) return segment_.motion;
  const Eigen::Vector3d motion = segment_.motion.vector() + segment_.J * offModel();
  return {motion.x(), motion.y(), motion.z()};
}

JointFilter::State JointFilter::predicted() const {
  if (segment_.duration == 0.0) return state_;
  const Eigen::Matrix3d R = rotation(state_.pose.yaw);
  const auto n = static_cast<Eigen::Index>(active_.size());
  const Pose2 motion = this->motion();
  const Eigen::Vector3d displacement = R * motion.vector();
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F(0, 2) = -displacement.y();
  F(1, 2) = displacement.x();
  Eigen::Matrix<double, 3, kCount> J = Eigen::Matrix<double, 3, kCount>::Zero();
  J.leftCols<kMotionCount>() = R * segment_.J;
  const MeasurementJacobian G = columns(J);
  State state = state_;
  state.pose = state_.pose * motion;
  // A P A^T, A = [F G; 0 I], which leaves the parameters' block as it is.
  const MeasurementJacobian AP = F.lazyProduct(state_.P.topRows<3>()) + G.lazyProduct(state_.P.bottomRows(n));
  state.P.topLeftCorner<3, 3>() = AP.leftCols<3>() * F.transpose() + AP.rightCols(n) * G.transpose() +
                                  R * segment_.covariance() * R.transpose();
  state.P.topRightCorner(3, n) = AP.rightCols(n);
  state.P.bottomLeftCorner(n, 3) = AP.rightCols(n).transpose();
  for (Eigen::Index k = 0; k < n; ++k)
    state.P(3 + k, 3 + k) +=
        random_walk_[static_cast<Eigen::Index>(active_[static_cast<std::size_t>(k)])] * segment_.distance;
  state.track_noise.transform(F);
  TrackNoise of_segment = segment_.track_noise;
  of_segment.transform(R * segment_.J_beginning());
  state.track_noise += of_segment;
  takeEvidence(state);
  return state;
}

/// The update by information = B B^T in Joseph form: as if B^T of the parameters' errors had been measured
/// with variance 1.
void JointFilter::takeEvidence(State& state) const {
  if (segment_.evidence.information.isZero(0.0)) return;
  const auto n = static_cast<Eigen::Index>(active_.size());
  StateMatrix information = StateMatrix::Zero(n, n);
  StateVector gradient = StateVector::Zero(3 + n);
  const Eigen::Matrix<double, kMotionCount, 1> about_estimate =
      segment_.evidence.gradient - segment_.evidence.information * offModel();
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(active_[static_cast<std::size_t>(i)]);
    if (row >= static_cast<Eigen::Index>(kMotionCount)) continue;
    gradient[3 + i] = about_estimate[row];
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto column = static_cast<Eigen::Index>(active_[static_cast<std::size_t>(j)]);
      if (column < static_cast<Eigen::Index>(kMotionCount))
        information(i, j) = segment_.evidence.information(row, column);
    }
  }
  const Eigen::LDLT<StateMatrix> root(information);
  const StateMatrix B = root.transpositionsP().transpose() * StateMatrix(root.matrixL()) *
                        root.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const StateMatrix PB = state.P.rightCols(n) * B;
  const StateMatrix S = StateMatrix::Identity(n, n) + B.transpose() * PB.bottomRows(n);
  const StateMatrix K = S.llt().solve(PB.transpose()).transpose();
  StateMatrix I_KB = StateMatrix::Identity(3 + n, 3 + n);
  I_KB.rightCols(n) -= K * B.transpose();
  // Joseph form, see correct().
  state.P = I_KB * state.P * I_KB.transpose() + K * K.transpose();
  shift(state.P * gradient, state);
}

void JointFilter::shift(const StateVector& change, State& state) const {
  state.pose.x += change[0];
  state.pose.y += change[1];
  state.pose.yaw += change[2];
  for (std::size_t k = 0; k < active_.size(); ++k)
    state.values[static_cast<Eigen::Index>(active_[k])] += change[static_cast<Eigen::Index>(3 + k)];
}

Pose2 JointFilter::expectedLaser(const State& state, double lead) const {
  const Pose2 laser = state.pose * mountOf(state.values);
  const Eigen::Vector3d moved = laserVelocity(state) * lead;
  return {laser.x + moved.x(), laser.y + moved.y(), laser.yaw + moved.z()};
}

Innovation JointFilter::update(const LaserPose& laser, double lead) {
  const State state = predicted();
  const Pose2 expected = expectedLaser(state, lead);
  const MeasurementJacobian H = measurementJacobian(state);
  Innovation innovation;
  innovation.residual = laser.pose.vector() - expected.vector();
  innovation.residual.z() = wrapAngle(innovation.residual.z());
  innovation.covariance = H.lazyProduct(state.P) * H.transpose() + laser.covariance;
  innovation.nis = innovation.residual.dot(innovation.covariance.llt().solve(innovation.residual));
  if (!std::isfinite(innovation.nis)) innovation.nis = std::numeric_limits<double>::max();
  innovation.weight = std::min(1.0, kSoftLimit / innovation.nis);
  if (!correct(state, H, laser.covariance, innovation)) innovation.weight = 0.0;
  return innovation;
}

/// The velocity of the laser, by which the time offset is found, has the same noise as the motion that its
/// pose is compared with: too fast a step looks like a late pose. Expected of dz/d tau^T S^-1 residual are
/// therefore not 0 but tr(S^-1 q), with q the noise of the motion in a second.
JointFilter::StateVector JointFilter::velocityBias(const MeasurementJacobian& H, const Eigen::Matrix3d& S,
                                                   const StateMatrix& P) const {
  StateVector change = StateVector::Zero(P.cols());
  const auto found = std::find(active_.begin(), active_.end(), static_cast<std::size_t>(kTimeOffset));
  if (found == active_.end() || !(segment_.duration > 0.0)) return change;
  const Eigen::Matrix3d J = H.leftCols<3>() * rotation(state_.pose.yaw);
  const Eigen::Matrix3d q = J * segment_.noise * J.transpose() / segment_.duration;
  return S.llt().solve(q).trace() * P.col(3 + (found - active_.begin()));
}

/// How much of a change of a parameter leads towards its prior and not beyond.
double JointFilter::shareTowardsPrior(std::size_t parameter, double change, const State& state) const {
  const auto k = static_cast<Eigen::Index>(parameter);
  const double to_prior = prior_[k] - state.values[k];
  if (!(change * to_prior > 0.0)) return 0.0;
  return std::min(1.0, to_prior / change);
}

/// (C14) What the noise in the tracks' columns seems to say of the tracks is known on average: it is taken
/// out of the estimate, and what it seems to inform out of P. Not beyond the prior: a noise level that is set
/// too high would drive the track away. Right where the pose alone takes up what the noise does: not beside a
/// mount or a delay that is sought, too.
/// @param M  H^T S^-1 H of the pose
void JointFilter::removeTrackNoise(const Eigen::Matrix3d& M, State& state) const {
  if (!takes_out_track_noise_ || !std::all_of(active_.begin(), active_.end(), isGain)) return;
  for (const Axle axle : kAllAxles) {
    const std::size_t track = TrackNoise::kTracks[index(axle)];
    const auto found = std::find(active_.begin(), active_.end(), track);
    if (found == active_.end()) continue;
    const Eigen::Index row = 3 + (found - active_.begin());
    const StateVector column = state.P.col(row);
    const double gradient = (M * state.track_noise.with_motion[axle]).trace();
    shift(shareTowardsPrior(track, gradient * column[row], state) * gradient * column, state);
    const double room = prior_variance_[static_cast<Eigen::Index>(track)] - column[row];
    const double information = std::min((M * state.track_noise.own[axle]).trace(),
                                        std::max(room, 0.0) / (column[row] * column[row]));
    state.P += information * column * column.transpose();
  }
}

/// @return false when the result was none: then nothing has changed
bool JointFilter::correct(const State& state, const MeasurementJacobian& H,
                          const Eigen::Matrix3d& laser_covariance, const Innovation& innovation) {
  const Eigen::Matrix3d R = laser_covariance / innovation.weight;
  const MeasurementJacobian HP = H.lazyProduct(state.P);
  const Eigen::Matrix3d S = HP * H.transpose() + R;
  const Eigen::LLT<Eigen::Matrix3d> factors(S);
  if (!S.allFinite() || factors.info() != Eigen::Success) return false;
  const Gain K = factors.solve(HP).transpose();
  const StateVector change = K * innovation.residual;
  // Joseph form, as two products that cannot be negative: multiplied out, differences of large numbers take
  // their place, and a covariance of the laser far below P leaves none that is positive semidefinite.
  const StateMatrix I_KH = StateMatrix::Identity(state.P.rows(), state.P.cols()) - K.lazyProduct(H);
  const Gain KR = K.lazyProduct(R);
  StateMatrix P = I_KH * state.P * I_KH.transpose() + KR.lazyProduct(K.transpose());
  if (!change.allFinite() || !P.allFinite()) return false;
  P = 0.5 * (P + P.transpose().eval());
  for (Eigen::Index i = 0; i < 3; ++i)
    P(i, i) = std::max(P(i, i), kPoseFloor * kPoseFloor * laser_covariance(i, i));
  const StateVector bias = velocityBias(H, S, P);
  state_ = {state.pose, state.values, P, state.track_noise};
  shift(change - bias, state_);
  const Eigen::Matrix3d H_pose = H.leftCols<3>();
  removeTrackNoise(H_pose.transpose() * factors.solve(H_pose), state_);
  state_.track_noise.transform(Eigen::Matrix3d::Identity() - K.topRows<3>() * H_pose);
  if (!elsewhere_) model_.setValues(state_.values);
  segment_ = segment_.next();
  return true;
}

bool JointFilter::lineariseAt(const std::optional<ParameterVector>& values) {
  elsewhere_ = values.has_value();
  model_.setValues(values.value_or(state_.values));
  segment_ = segment_.next();
  return true;
}

bool JointFilter::restore(const ParameterVector& values, const ParameterMatrix& covariance) {
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(active_[i]);
    state_.values[row] = values[row];
    for (std::size_t j = 0; j < active_.size(); ++j)
      state_.P(static_cast<Eigen::Index>(3 + i), static_cast<Eigen::Index>(3 + j)) =
          covariance(row, static_cast<Eigen::Index>(active_[j]));
  }
  model_.setValues(state_.values);
  segment_ = MotionSegment();
  return true;
}

FilterEstimate JointFilter::estimate() const {
  const State state = predicted();
  FilterEstimate estimate;
  estimate.pose = state.pose;
  estimate.pose_covariance = state.P.topLeftCorner<3, 3>();
  estimate.values = state.values;
  for (std::size_t i = 0; i < active_.size(); ++i) {
    const auto to = static_cast<Eigen::Index>(active_[i]);
    const auto from = static_cast<Eigen::Index>(3 + i);
    estimate.cross.col(to) = state.P.block<3, 1>(0, from);
    for (std::size_t j = 0; j < active_.size(); ++j)
      estimate.covariance(to, static_cast<Eigen::Index>(active_[j])) =
          state.P(from, static_cast<Eigen::Index>(3 + j));
  }
  setDistanceGains(model_.vehicle(), estimate);
  return estimate;
}

}  // namespace bs_car_odometry::calibration
