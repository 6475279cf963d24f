#include "monte_carlo.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <functional>
#include <thread>

namespace bs_car_odometry::drives {

namespace {

/// What an odometry says of a drive, and what is true.
struct Judged {
  OdometryEstimate estimate;
  simulation::Pose truth;
};
using Judge = std::function<Judged(const OdometryConfiguration&, const std::vector<Sample>&)>;

void simulateDrive(const MonteCarloSettings& settings, const Judge& judge, std::size_t i,
                   std::vector<EndErrors>& results) {
  DriveSettings drive = settings.drive;
  drive.seed += i;
  const std::vector<Sample> samples = record(settings.odometries.front().vehicle, drive);
  for (std::size_t k = 0; k < settings.odometries.size(); ++k) {
    const auto [estimate, truth] = judge(settings.odometries[k], samples);
    results[k].errors[i] = estimate.pose.vector() - Eigen::Vector3d(truth.x, truth.y, truth.yaw);
    results[k].nees[i] = normalisedError(estimate, truth);
  }
}

std::vector<EndErrors> simulate(const MonteCarloSettings& settings, const Judge& judge) {
  std::vector<EndErrors> results(settings.odometries.size());
  for (EndErrors& result : results) {
    result.errors.resize(settings.drives);
    result.nees.resize(settings.drives);
  }
  const std::size_t threads = std::max(1U, std::thread::hardware_concurrency());
  std::vector<std::thread> workers;
  for (std::size_t first = 0; first < threads; ++first)
    workers.emplace_back([&settings, &judge, &results, first, threads] {
      for (std::size_t i = first; i < settings.drives; i += threads)
        simulateDrive(settings, judge, i, results);
    });
  for (std::thread& worker : workers) worker.join();
  return results;
}

}  // namespace

std::vector<EndErrors> simulateDrives(const MonteCarloSettings& settings) {
  return simulate(settings, [](const OdometryConfiguration& odometry, const std::vector<Sample>& drive) {
    return Judged{endOf(odometry, drive), drive.back().truth};
  });
}

std::vector<EndErrors> simulateMotions(const MonteCarloSettings& settings, const Interval& interval) {
  return simulate(settings, [&interval](const OdometryConfiguration& odometry,
                                        const std::vector<Sample>& drive) {
    const MotionEstimate motion = motionBetween(odometry, drive, interval.from, interval.to, interval.every);
    const OdometryEstimate estimate{motion.motion, motion.covariance, Eigen::Vector3d::Zero(),
                                    Eigen::Matrix3d::Zero()};
    return Judged{estimate, trueMotion(drive, interval.from, interval.to)};
  });
}

Eigen::Vector3d EndErrors::mean() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& error : errors) sum += error;
  return sum / static_cast<double>(errors.size());
}

Eigen::Matrix3d EndErrors::covariance() const {
  const Eigen::Vector3d centre = mean();
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& error : errors) sum += (error - centre) * (error - centre).transpose();
  return sum / static_cast<double>(errors.size() - 1);
}

double EndErrors::meanNees() const {
  double sum = 0.0;
  for (const double value : nees) sum += value;
  return sum / static_cast<double>(nees.size());
}

double normalisedError(const OdometryEstimate& estimate, const simulation::Pose& truth) {
  const double e = wrapAngle(truth.yaw - estimate.pose.yaw);
  const double c = std::cos(estimate.pose.yaw);
  const double s = std::sin(estimate.pose.yaw);
  Eigen::Matrix3d Q = Eigen::Matrix3d::Identity();
  Q.topLeftCorner<2, 2>() << c, s, -s, c;
  const Eigen::Vector3d d = Q * Eigen::Vector3d(truth.x - estimate.pose.x, truth.y - estimate.pose.y, e);
  const double A = std::cos(0.5 * e) / sinc(0.5 * e);  // (e/2) / tan(e/2)
  const Eigen::Vector3d xi(A * d.x() + 0.5 * e * d.y(), -0.5 * e * d.x() + A * d.y(), e);
  return xi.dot((Q * estimate.pose_covariance * Q.transpose()).inverse() * xi);
}

}  // namespace bs_car_odometry::drives
