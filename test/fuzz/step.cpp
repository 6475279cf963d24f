// Messages, poses, resets and calibrations in any order with any content, through the odometry without ROS.
// Finite, covariances symmetric and positive semidefinite, stamps strictly increasing within a run.

#include "bytes.hpp"

#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/core/systematic_prior.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <optional>

namespace bs_car_odometry::fuzz {
namespace {

constexpr std::int64_t kStart = 1600000000000000000;  // ns

OdometryConfiguration configuration(Bytes& bytes) {
  OdometryConfiguration configuration;
  Vehicle& vehicle = configuration.vehicle;
  vehicle.wheelbase = 1.2;
  vehicle.track = {1.2, 1.1};
  vehicle.base_link_x = bytes.flag() ? 0.4 : 0.0;
  vehicle.metres_per_tick.values.fill(1e-4);
  if (bytes.flag()) vehicle.metres_per_tick[Wheel::kFrontLeft] = 0.0;
  const int counter_bits[] = {32, 16, 0, 64};
  vehicle.counter_bits = counter_bits[bytes.below(4)];
  if (bytes.flag()) vehicle.rear_steering.source = RearSteering::Source::kMeasured;
  if (bytes.flag()) {
    vehicle.axle_geometry = AxleGeometry::kPivot;
    vehicle.hub_offset = {0.05, 0.05};
  }
  OdometryOptions& options = configuration.options;
  const std::size_t axles_and_history = bytes.below(24);
  options.axles = static_cast<AxleSelection>(axles_and_history % 3);
  // The memory that it reserves takes longer than the steps.
  if (axles_and_history < 21) configuration.relative_motion.history = Duration::zero();
  options.uncertainty = static_cast<Uncertainty>(bytes.below(4));  // particles need their own time
  options.systematic_rule = static_cast<SystematicRule>(bytes.below(2));
  configuration.initial_pose.covariance = Eigen::Vector3d(1e-4, 2e-4, 3e-4).asDiagonal();
  return configuration;
}

/// The core believes the covariances that it is given: whoever gives them has checked them.
Eigen::Matrix3d diagonal(Bytes& bytes) {
  Eigen::Vector3d variances;
  for (double& variance : variances) variance = std::ldexp(1.0, static_cast<int>(bytes.below(60)) - 30);
  return variances.asDiagonal();
}

class Run {
 public:
  explicit Run(Bytes& bytes) : bytes_(bytes), pipeline_(configuration(bytes)) {}

  void drive() {
    constexpr int kMost = 500;
    for (int i = 0; i < kMost && bytes_.sound(); ++i) {
      act();
      while (const std::optional<OdometryUpdate> update = pipeline_.next(now_)) check(*update);
      pipeline_.deadline();
    }
  }

 private:
  /// Soon after the last message, or anywhere.
  Time stamp() {
    const std::size_t kind = bytes_.below(8);
    if (kind == 0)
      return timeFromNanoseconds(static_cast<std::int64_t>(bytes_.value<std::uint32_t>()) * 1000000000 +
                                 bytes_.value<std::uint32_t>() % 1000000000);
    if (kind == 1) return now_ - Duration(bytes_.value<std::int32_t>());
    now_ += Duration(bytes_.value<std::uint16_t>() * 1000);  // up to 66 ms
    return now_;
  }

  void act() {
    switch (bytes_.below(16)) {
      case 0:
        return pipeline_.reset();
      case 1:
        return setPose();
      case 2:
        return calibrate();
      case 3:
        return turnBackTime();
      case 4:
      case 5:
      case 6:
      case 7:
        return steer();
      default:
        return turnWheels();
    }
  }

  void steer() {
    const Axle axle = bytes_.flag() ? Axle::kFront : Axle::kRear;
    const Time at = stamp();
    const double angle =
        bytes_.flag() ? bytes_.number() : 4e-5 * static_cast<double>(bytes_.value<std::int16_t>());
    pipeline_.addSteering(axle, at, now_, angle);
  }

  void turnWheels() {
    const Time at = stamp();
    const bool any = bytes_.below(4) == 0;
    for (std::int64_t& count : ticks_.values) {
      if (any) {
        count = bytes_.value<std::int64_t>();
      } else {
        count = static_cast<std::int64_t>(static_cast<std::uint64_t>(count) +
                                          static_cast<std::uint64_t>(bytes_.value<std::int8_t>()));
      }
    }
    pipeline_.addWheels({at, now_, ticks_});
  }

  /// As far away as messages may put the car.
  void setPose() {
    constexpr double kFarthest = 1e9;
    Pose2 pose{bytes_.number(), bytes_.number(), bytes_.number()};
    for (double* number : {&pose.x, &pose.y, &pose.yaw})
      *number = std::isfinite(*number) ? std::clamp(*number, -kFarthest, kFarthest) : 0.0;
    pipeline_.setPose(pose, diagonal(bytes_));
  }

  void calibrate() {
    OdometryCalibration calibration = pipeline_.calibration();
    const auto around = [this](double width) {
      return width * static_cast<double>(bytes_.value<std::int8_t>()) / 128.0;
    };
    for (const Axle axle : kAllAxles) {
      calibration.gains[axle] = {1.0 + around(0.4), 1.0 + around(0.4), 1.0 + around(0.4)};
      calibration.steering[axle] = {1.0 + around(0.4), around(0.4)};
    }
    for (Eigen::Index i = 0; i < calibration.covariance.rows(); ++i)
      calibration.covariance(i, i) = std::ldexp(1.0, -static_cast<int>(bytes_.below(40)));
    for (Eigen::Index i = 0; i < calibration.covariance.rows(); ++i)
      for (Eigen::Index j = 0; j < calibration.covariance.cols(); ++j)
        if (i != j) calibration.covariance(i, j) = 0.0;
    pipeline_.setCalibration(calibration);
  }

  void turnBackTime() {
    now_ -= Duration(static_cast<std::int64_t>(bytes_.value<std::uint16_t>()) * 1000000);
    newest_.reset();
    if (bytes_.flag()) return pipeline_.restart();
    pipeline_.rebaseTime();
  }

  void check(const OdometryUpdate& update) {
    const OdometryEstimate& estimate = update.estimate;
    require(estimate.pose.isFinite(), "the pose is finite");
    require(estimate.twist.allFinite(), "the twist is finite");
    require(std::isfinite(update.report.distance + update.report.step), "the step is finite");
    checkCovariance(estimate.pose_covariance);
    checkCovariance(estimate.twist_covariance);
    require(!newest_ || update.stamp > *newest_, "stamps increase");
    newest_ = update.stamp;
  }

  static void checkCovariance(const Eigen::Matrix3d& covariance) {
    require(covariance.allFinite(), "the covariance is finite");
    require(covariance == covariance.transpose(), "the covariance is symmetric");
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
    const double largest = std::max(solver.eigenvalues().maxCoeff(), 0.0);
    require(solver.eigenvalues().minCoeff() >= -1e-12 * largest, "the covariance is positive semidefinite");
  }

  Bytes& bytes_;
  OdometryPipeline pipeline_;
  Time now_{timeFromNanoseconds(kStart)};
  PerWheel<std::int64_t> ticks_;
  std::optional<Time> newest_;
};

}  // namespace
}  // namespace bs_car_odometry::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::vector<std::uint8_t> input(data, data + size);
  bs_car_odometry::fuzz::Bytes bytes(input);
  bs_car_odometry::fuzz::Run(bytes).drive();
  return 0;
}
