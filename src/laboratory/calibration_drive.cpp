#include "bs_car_odometry/laboratory/calibration_drive.hpp"

#include "bs_car_odometry/calibration/odometry_for_calibration.hpp"
#include "bs_car_odometry/calibration/planar.hpp"
#include "bs_car_odometry/parameters/configuration.hpp"
#include "bs_car_odometry/simulation/random.hpp"
#include "bs_car_odometry/simulation/true_parameters.hpp"

namespace bs_car_odometry::laboratory {

namespace {

// Streams of the random numbers, apart from those of the simulated car.
constexpr std::uint64_t kGainStream = 200;
constexpr std::uint64_t kLaserStream = 201;
constexpr std::uint64_t kOutlierStream = 202;
constexpr std::uint64_t kDelayStream = 203;

using simulation::Random;

double gainError(const TrueGains& gains, Random& random) {
  if (gains.kind == TrueGains::Kind::kDrawn) return gains.size * random.normal();
  return random.uniform() < 0.5 ? -gains.size : gains.size;
}

double uniformWithin(double half_width, Random& random) {
  return half_width * (2.0 * random.uniform() - 1.0);
}

}  // namespace

Vehicle trueVehicle(const Vehicle& configured, const TrueGains& gains, std::uint64_t seed) {
  Vehicle vehicle = configured;
  if (gains.kind == TrueGains::Kind::kConfigured) return vehicle;
  if (gains.kind == TrueGains::Kind::kScenario) {
    vehicle.gains = simulation::withScenarioGains(configured).gains;
    return vehicle;
  }
  Random random(seed, kGainStream);
  for (const Axle axle : kAllAxles) {
    AxleGains& axle_gains = vehicle.gains[axle];
    for (double* gain : {&axle_gains.k_r, &axle_gains.k_l, &axle_gains.k_b})
      *gain += gainError(gains, random);
  }
  return vehicle;
}

double delayOf(const LaserErrors& errors, std::uint64_t seed) {
  return errors.delay + errors.delay_draw * Random(seed, kDelayStream).uniform();
}

std::vector<calibration::LaserPose> laserPoses(const KnownDrive& drive, const LaserErrors& errors,
                                               double delay, std::uint64_t seed) {
  Random random(seed, kLaserStream);
  Random outliers(seed, kOutlierStream);
  const LaserSigma& sigma = drive.truth.laser_sigma;
  const Eigen::Vector3d deviations(sigma.position, sigma.position, sigma.yaw);
  std::vector<calibration::LaserPose> poses;
  for (std::size_t i = 0; i < drive.samples.size(); i += kLaserEvery) {
    const Sample& sample = drive.samples[i];
    const Pose2 base{sample.truth.x, sample.truth.y, sample.truth.yaw};
    Pose2 pose = base * calibration::mountOf(drive.truth.laser);
    for (const auto& [value, deviation] :
         {std::pair(&pose.x, sigma.position), {&pose.y, sigma.position}, {&pose.yaw, sigma.yaw}})
      if (errors.noise) *value += deviation * random.normal();
    const bool outlier = outliers.uniform() <= errors.outliers;
    for (const auto& [value, width] :
         {std::pair(&pose.x, errors.position), {&pose.y, errors.position}, {&pose.yaw, errors.yaw}}) {
      const double error = uniformWithin(width, outliers);
      if (outlier) *value += error;
    }
    pose.yaw = wrapAngle(pose.yaw);
    poses.push_back(
        {stampOf(sample) + durationFromSeconds(delay), pose, deviations.cwiseAbs2().asDiagonal()});
  }
  return poses;
}

std::vector<OdometryUpdate> odometryOf(const Parameters& configured, const std::vector<Sample>& samples) {
  const OdometryConfiguration configuration =
      toConfiguration(calibration::odometryForCalibration(configured));
  std::vector<OdometryUpdate> updates;
  updates.reserve(samples.size());
  replay(configuration, samples,
         [&](const Sample& /*sample*/, const OdometryUpdate& update) { updates.push_back(update); });
  return updates;
}

}  // namespace bs_car_odometry::laboratory
