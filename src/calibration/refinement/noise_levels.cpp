#include "bs_car_odometry/calibration/noise_levels.hpp"

#include "fit.hpp"
#include "noise_likelihood.hpp"

#include <cmath>

namespace bs_car_odometry::calibration {

namespace {

constexpr int kMostRounds = 8;
constexpr double kSettled = 0.1;  // standard deviations that a level may still move in the last round

/// Root mean square of the standard deviations that the laser poses came with.
LaserSigma rootMeanSquare(const Drives& drives) {
  double position = 0.0;
  double yaw = 0.0;
  std::size_t count = 0;
  for (const CalibrationDrive* drive : drives)
    for (const DriveLaser& laser : drive->lasers()) {
      position += 0.5 * laser.laser.covariance.topLeftCorner<2, 2>().trace();
      yaw += laser.laser.covariance(2, 2);
      ++count;
    }
  const double n = static_cast<double>(std::max<std::size_t>(count, 1));
  return {std::sqrt(position / n), std::sqrt(yaw / n)};
}

NoiseLevel level(double configured, double scale, double deviation, bool found) {
  const double value = configured * scale;
  return {configured, value, found ? value * deviation : 0.0, found};
}

}  // namespace

/// Fit and levels in turn: each is linear about the other.
NoiseLevels estimateNoise(const Drives& drives, const Parameters& parameters,
                          const RefinementOptions& options) {
  const double wheel = parameters.noise.wheel.std();
  const LaserScales given = options.laser_scales;
  RefinementOptions now = options;
  Parameters noisy = parameters;
  LevelVector logs = LevelVector::Zero();
  LevelEstimate found;
  for (int round = 0; round < kMostRounds && !found.converged; ++round) {
    noisy.noise.wheel = wheel * std::exp(logs[0]);
    now.laser_scales = {given.position * std::exp(logs[1]), given.yaw * std::exp(logs[2])};
    Fit fit(drives, noisy, now);
    fit.run();
    now.seed = fit.values();
    std::vector<Chain> chains = fit.chainsWithWheelNoise();
    found = fitLevels(chains, fit.prior(), fit.values());
    for (int k = 0; k < kLevels; ++k)
      logs[k] = found.found[static_cast<std::size_t>(k)] ? logs[k] + found.logs[k] : 0.0;
    const bool settled = (found.logs.array().abs() <= kSettled * found.deviations.array()).all();
    found.converged = found.converged && settled && fit.converged();
  }
  if (!found.converged) {  // where the search stood is no level, and may not be a number
    logs.setZero();
    found.found.fill(false);
  }
  const LaserSigma laser = rootMeanSquare(drives);
  NoiseLevels levels;
  levels.wheel = level(wheel, std::exp(logs[0]), found.deviations[0], found.found[0]);
  levels.laser_position =
      level(laser.position, given.position * std::exp(logs[1]), found.deviations[1], found.found[1]);
  levels.laser_yaw = level(laser.yaw, given.yaw * std::exp(logs[2]), found.deviations[2], found.found[2]);
  levels.outliers = found.outliers;
  levels.converged = found.converged;
  return levels;
}

Parameters withNoise(const NoiseLevels& levels, Parameters parameters) {
  if (levels.wheel.found) parameters.noise.wheel = levels.wheel.value;
  return parameters;
}

}  // namespace bs_car_odometry::calibration
