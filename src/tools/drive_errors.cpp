#include "drive_errors.hpp"

#include "bs_car_odometry/ros/odometry_adapter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace bs_car_odometry::tools {

namespace {

constexpr double kGainStep = 1e-5;
constexpr double kVarianceStep = 0.1;  // relative; exact for one axle, where the covariance is linear

/// Odometry at one wheel message, tracked point from where it was at the first true pose.
struct Reckoned {
  Time stamp;
  Pose2 pose;
  Eigen::Matrix3d covariance;
  double travelled{0.0};  ///< [m], mean of the wheels
};

double meanTravel(const StepReport& report) {
  double sum = 0.0;
  double wheels = 0.0;
  for (const Wheel wheel : kAllWheels) {
    if (!report.wheel_used[wheel]) continue;
    sum += std::abs(report.wheel_travel[wheel]);
    wheels += 1.0;
  }
  return wheels > 0.0 ? sum / wheels : 0.0;
}

/// [I, f; 0, 1] with f = rotate90(d): what a displacement d makes of an error of heading.
Eigen::Matrix3d leverOf(const Eigen::Vector2d& d) {
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F(0, 2) = -d.y();
  F(1, 2) = d.x();
  return F;
}

/// One pass of the odometry over a drive.
class DeadReckoning {
 public:
  DeadReckoning(const RecordedDrive& drive, Parameters parameters)
      : drive_(drive), parameters_(prepared(std::move(parameters))), adapter_(parameters_) {}

  std::vector<Reckoned> run() {
    for (const InputMessage& input : drive_.inputs) {
      drain(input.receipt);
      std::visit([&](const auto& content) { add(content, input.receipt); }, input.content);
      drain(input.receipt);
    }
    drain(ros::TIME_MAX);
    return std::move(path_);
  }

 private:
  /// The noise of the readings alone, to first order: the likelihood is that of a linear model. All readings:
  /// what contradicts the rest depends on the noise that is looked for.
  static Parameters prepared(Parameters p) {
    p.odometry.uncertainty = Uncertainty::kFirstOrder;
    p.odometry.fault_detection = false;
    p.noise.systematic = {0.0, 0.0, 0.0, 0.0};
    p.systematic_covariance.reset();
    p.relative_motion.history = Duration::zero();  // nobody asks
    return p;
  }

  void add(const AxleReading& reading, const ros::Time& receipt) {
    adapter_.add(reading.axle, reading.message, receipt);
  }
  template <typename Message>
  void add(const Message& message, const ros::Time& receipt) {
    adapter_.add(message, receipt);
  }

  void drain(const ros::Time& now) {
    while (const std::optional<OdometryUpdate> update = adapter_.next(now)) {
      if (update->stamp < drive_.truth.front().stamp) continue;
      if (path_.empty()) {
        begin(*update);
      } else {
        add(*update);
      }
    }
  }

  /// Error and covariance begin at the first true pose.
  void begin(const OdometryUpdate& update) {
    geometry_msgs::PoseWithCovarianceStamped origin;
    origin.pose.pose.orientation.w = 1.0;
    adapter_.setPose(origin);
    path_.push_back({update.stamp, {}, Eigen::Matrix3d::Zero()});
  }

  void add(const OdometryUpdate& update) {
    const Pose2& base = update.estimate.pose;
    const Pose2& point = drive_.tracked_point;
    const Pose2 pose = inverse(point) * base * point;
    const Eigen::Matrix3d J = toFirstPoint() * leverOf((base * point).position() - base.position());
    path_.push_back({update.stamp, pose, J * update.estimate.pose_covariance * J.transpose(),
                     path_.back().travelled + meanTravel(update.report)});
  }

  /// Rotation from odom into the first frame of the tracked point.
  Eigen::Matrix3d toFirstPoint() const {
    const double yaw = drive_.tracked_point.yaw;
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    R.topLeftCorner<2, 2>() << std::cos(yaw), std::sin(yaw), -std::sin(yaw), std::cos(yaw);
    return R;
  }

  const RecordedDrive& drive_;
  Parameters parameters_;
  OdometryAdapter adapter_;
  std::vector<Reckoned> path_;
};

/// Compares one drive with its truth.
class Comparison {
 public:
  Comparison(const RecordedDrive& drive, const Parameters& parameters, const NoiseUnknowns& unknowns,
             const ErrorSettings& settings)
      : drive_(drive),
        parameters_(withNoise(parameters, unknowns)),
        unknowns_(unknowns),
        settings_(settings),
        path_(reckon(parameters_)) {}

  DriveErrors run() {
    choosePlaces();
    DriveErrors errors;
    errors.odometry = path_[places_.back()].pose;
    errors.truth = truth_.back();
    errors.distance = path_[places_.back()].travelled;
    LinearDrive all;
    all.error = error();
    all.sensitivity = sensitivity();
    all.components = components();
    all.known = known(all.components);
    const Eigen::Index n = all.error.size();
    errors.end = rows(all, {n - 3, n - 2, n - 1});
    errors.path = rows(all, comparedRows());
    return errors;
  }

 private:
  /// A little of every noise that is sought: a difference around nothing is none.
  static Parameters withNoise(Parameters parameters, const NoiseUnknowns& unknowns) {
    for (const UnknownNoise& noise : unknowns.path) {
      Distribution& std = noise.value(parameters.noise);
      if (std.std() < noise.least) std = noise.least;
    }
    return parameters;
  }

  std::vector<Reckoned> reckon(const Parameters& parameters) const {
    return DeadReckoning(drive_, parameters).run();
  }

  /// Poses of the odometry with a truth; the first of all must have one, as that is where both begin.
  std::vector<std::size_t> posesWithTruth() const {
    std::vector<std::size_t> poses;
    for (std::size_t i = 0; i < path_.size(); ++i)
      if (drive_.truthAt(path_[i].stamp, parameters_.limits.max_gap)) poses.push_back(i);
    if (poses.size() < 2 || poses.front() != 0)
      throw InputError(
          drive_.name +
          ": no true poses around the beginning of the odometry that are closer together than max_gap");
    return poses;
  }

  /// The marks along the way, and the last pose with a truth.
  void choosePlaces() {
    const std::vector<std::size_t> poses = posesWithTruth();
    const double length = path_[poses.back()].travelled;
    if (!(length > 0.0)) {  // parked: its end alone
      places_.push_back(poses.back());
      return readTruth();
    }
    const double marks =
        std::clamp(std::round(length / settings_.spacing), 1.0, static_cast<double>(settings_.most_places));
    double next = length / marks;
    for (const std::size_t i : poses) {
      const double travelled = path_[i].travelled;
      if (travelled < next || travelled > length * (1.0 - 0.5 / marks)) continue;
      places_.push_back(i);
      while (next <= travelled) next += length / marks;
    }
    places_.push_back(poses.back());
    readTruth();
  }

  void readTruth() {
    const Duration max_gap = parameters_.limits.max_gap;
    const InterpolatedPose start = *drive_.truthAt(path_.front().stamp, max_gap);
    start_variance_ = start.variance;
    for (const std::size_t i : places_) {
      const InterpolatedPose truth = *drive_.truthAt(path_[i].stamp, max_gap);
      truth_.push_back(inverse(start.pose) * truth.pose);
      truth_variance_.push_back(truth.variance);
    }
  }

  Eigen::Index places() const { return static_cast<Eigen::Index>(places_.size()); }

  Eigen::VectorXd error() const {
    Eigen::VectorXd e(3 * places());
    for (std::size_t i = 0; i < places_.size(); ++i) {
      Eigen::Vector3d difference = truth_[i].vector() - path_[places_[i]].pose.vector();
      difference.z() = wrapAngle(difference.z());
      e.segment<3>(3 * static_cast<Eigen::Index>(i)) = difference;
    }
    return e;
  }

  Eigen::MatrixXd sensitivity() const {
    Eigen::MatrixXd Phi(3 * places(), static_cast<Eigen::Index>(unknowns_.gains.size()));
    for (std::size_t j = 0; j < unknowns_.gains.size(); ++j) {
      Parameters above = parameters_;
      Parameters below = parameters_;
      unknowns_.gains[j].value(above) += kGainStep;
      unknowns_.gains[j].value(below) -= kGainStep;
      const std::vector<Reckoned> path_above = reckon(above);
      const std::vector<Reckoned> path_below = reckon(below);
      for (std::size_t i = 0; i < places_.size(); ++i)
        Phi.block<3, 1>(3 * static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            (path_above[places_[i]].pose.vector() - path_below[places_[i]].pose.vector()) / (2.0 * kGainStep);
    }
    return Phi;
  }

  /// Joint covariance of all places from the covariance at each: Cov(e_i, e_j) = Sigma_i F^T for i before j,
  /// since what comes between is independent of e_i.
  Eigen::MatrixXd joint(const std::vector<Eigen::Matrix3d>& covariances) const {
    Eigen::MatrixXd V(3 * places(), 3 * places());
    for (Eigen::Index i = 0; i < places(); ++i) {
      for (Eigen::Index j = i; j < places(); ++j) {
        const Eigen::Matrix3d F = leverOf(position(j) - position(i));
        V.block<3, 3>(3 * i, 3 * j) = covariances[static_cast<std::size_t>(i)] * F.transpose();
        V.block<3, 3>(3 * j, 3 * i) = V.block<3, 3>(3 * i, 3 * j).transpose();
      }
    }
    return V;
  }

  Eigen::Vector2d position(Eigen::Index place) const {
    return path_[places_[static_cast<std::size_t>(place)]].pose.position();
  }

  std::vector<Eigen::Matrix3d> covariances(const std::vector<Reckoned>& path) const {
    std::vector<Eigen::Matrix3d> covariances;
    for (const std::size_t i : places_) covariances.push_back(path[i].covariance);
    return covariances;
  }

  /// dV/d(variance) of each noise.
  std::vector<Eigen::MatrixXd> components() const {
    std::vector<Eigen::MatrixXd> components;
    for (const UnknownNoise& noise : unknowns_.path) {
      const auto at = [&](double factor) {
        Parameters changed = parameters_;
        Distribution& std = noise.value(changed.noise);
        std = std::sqrt(factor) * std.std();
        return joint(covariances(reckon(changed)));
      };
      const double variance = varianceOf(noise);
      components.push_back((at(1.0 + kVarianceStep) - at(1.0 - kVarianceStep)) /
                           (2.0 * kVarianceStep * variance));
    }
    return components;
  }

  double varianceOf(const UnknownNoise& noise) const {
    NoiseModel model = parameters_.noise;
    return noise.value(model).variance();
  }

  /// The truth's errors, and the noise that is not sought: what the components leave of the odometry's.
  Eigen::MatrixXd known(const std::vector<Eigen::MatrixXd>& components) const {
    Eigen::MatrixXd V = joint(covariances(path_));
    for (std::size_t k = 0; k < components.size(); ++k) V -= varianceOf(unknowns_.path[k]) * components[k];
    const double position_variance = std::pow(settings_.truth_position, 2);
    const Eigen::Vector3d truth(position_variance, position_variance, std::pow(settings_.truth_yaw, 2));
    Eigen::MatrixXd start(3 * places(), 3);
    for (Eigen::Index i = 0; i < places(); ++i) {
      start.block<3, 3>(3 * i, 0) = leverOf(position(i));
      V.diagonal().segment<3>(3 * i) += truth_variance_[static_cast<std::size_t>(i)] * truth;
    }
    return V + start * (start_variance_ * truth).asDiagonal() * start.transpose();
  }

  std::vector<Eigen::Index> comparedRows() const {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index i = 0; i < 3 * places(); ++i)
      if (settings_.headings || i % 3 != 2) rows.push_back(i);
    return rows;
  }

  static LinearDrive rows(const LinearDrive& all, const std::vector<Eigen::Index>& kept) {
    const auto n = static_cast<Eigen::Index>(kept.size());
    Eigen::MatrixXd pick = Eigen::MatrixXd::Zero(n, all.error.size());
    for (Eigen::Index i = 0; i < n; ++i) pick(i, kept[static_cast<std::size_t>(i)]) = 1.0;
    LinearDrive part{pick * all.error, pick * all.sensitivity, pick * all.known * pick.transpose(), {}};
    for (const Eigen::MatrixXd& V : all.components) part.components.push_back(pick * V * pick.transpose());
    return part;
  }

  const RecordedDrive& drive_;
  Parameters parameters_;
  const NoiseUnknowns& unknowns_;
  const ErrorSettings& settings_;
  std::vector<Reckoned> path_;
  std::vector<std::size_t> places_;     ///< indices into the path
  std::vector<Pose2> truth_;            ///< at the places
  std::vector<double> truth_variance_;  ///< in units of that of one true pose
  double start_variance_{1.0};
};

}  // namespace

DriveErrors driveErrors(const RecordedDrive& drive, const Parameters& parameters,
                        const NoiseUnknowns& unknowns, const ErrorSettings& settings) {
  return Comparison(drive, parameters, unknowns, settings).run();
}

}  // namespace bs_car_odometry::tools
