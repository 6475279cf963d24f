#include "simulated_calibration.hpp"

#include "bs_car_odometry/calibration/drive_bound.hpp"
#include "bs_car_odometry/calibration/odometry_for_calibration.hpp"
#include "bs_car_odometry/calibration/planar.hpp"
#include "bs_car_odometry/parameters/configuration.hpp"
#include "bs_car_odometry/simulation/random.hpp"
#include "calibration_drive.hpp"

#include <cmath>

namespace bs_car_odometry::calibration {

namespace {

constexpr std::uint64_t kTruthStream = 200;  // apart from those of the simulated car
constexpr std::uint64_t kLaserStream = 201;
const Pose2 kJump{3.0, -2.0, 0.5};  // of the map

class Laser {
 public:
  Laser(const SimulatedDrive& simulated, const LaserSigma& believed)
      : simulated_(simulated), believed_(believed), random_(simulated.seed, kLaserStream) {}

  LaserPose read(const laboratory::Sample& sample) {
    const ParameterVector& truth = simulated_.truth;
    LaserPose laser;
    laser.stamp = laboratory::stampOf(sample) + durationFromSeconds(truth[kTimeOffset]);
    laser.pose = Pose2{sample.truth.x, sample.truth.y, sample.truth.yaw} * mountOf(truth);
    const bool outlier = random_.uniform() <= simulated_.outliers.share;
    const LaserSigma& sigma = simulated_.laser_sigma;
    laser.pose.x += outlier ? spread(simulated_.outliers.position) : sigma.position * random_.normal();
    laser.pose.y += outlier ? spread(simulated_.outliers.position) : sigma.position * random_.normal();
    laser.pose.yaw += outlier ? spread(simulated_.outliers.yaw) : sigma.yaw * random_.normal();
    laser.pose.yaw = wrapAngle(laser.pose.yaw);
    if (simulated_.jump_after > 0.0 && sample.time > simulated_.jump_after) laser.pose = kJump * laser.pose;
    const Eigen::Vector3d deviations(believed_.position, believed_.position, believed_.yaw);
    laser.covariance = deviations.cwiseAbs2().asDiagonal();
    return laser;
  }

 private:
  double spread(double limit) { return limit * (2.0 * random_.uniform() - 1.0); }

  const SimulatedDrive& simulated_;
  LaserSigma believed_;
  simulation::Random random_;
};

}  // namespace

Parameters cycabParameters(AxleSelection axles) {
  Parameters parameters;
  parameters.vehicle.wheelbase = 1.2;
  parameters.vehicle.track = {1.2, 1.2};
  for (const Wheel wheel : kAllWheels) parameters.vehicle.metres_per_tick[wheel] = 1e-5;
  parameters.odometry.axles = axles;
  return parameters;
}

ParameterVector drawTruth(const Parameters& parameters, std::uint64_t seed) {
  simulation::Random random(seed, kTruthStream);
  ParameterVector truth = valuesOf(parameters);
  const ParameterVector deviations = priorDeviations(parameters);
  for (Eigen::Index i = 0; i < truth.size(); ++i) truth[i] += deviations[i] * random.normal();
  return truth;
}

CalibratedDrive calibrate(const SimulatedDrive& simulated, const Parameters& parameters) {
  Vehicle vehicle = parameters.vehicle;
  setValues(simulated.truth, vehicle);
  laboratory::DriveSettings settings;
  settings.scenario = simulated.scenario;
  settings.duration = simulated.duration;
  settings.rate = simulated.rate;
  settings.seed = simulated.seed;
  settings.substep = 0.01;
  settings.axles = parameters.odometry.axles;
  settings.noise = simulated.noise;
  const std::vector<laboratory::Sample> samples = laboratory::record(vehicle, settings);

  std::vector<LaserPose> lasers;
  Laser laser(simulated, parameters.laser_sigma);
  for (std::size_t i = 0; i < samples.size(); i += laboratory::kLaserEvery)
    lasers.push_back(laser.read(samples[i]));

  Calibrator calibrator(parameters);
  DriveRecorder recorder;
  calibrator.setListener([&](const CalibrationUpdate& update) { recorder.add(update, calibrator.counts()); });
  calibrate(calibrator, parameters, samples, lasers, 0,
            [&](const OdometryUpdate& update) { recorder.add(update); });
  return {recorder.take(), calibrator.estimate()};
}

Parameters withPrior(double prior, AxleSelection axles) {
  Parameters parameters = cycabParameters(axles);
  parameters.calibration.prior.k_r = prior;
  parameters.calibration.prior.k_l = prior;
  parameters.calibration.prior.k_b = prior;
  return parameters;
}

SimulatedDrive drawnDrive(const std::string& scenario, const Parameters& parameters, std::uint64_t seed) {
  SimulatedDrive drive;
  drive.scenario = scenario;
  drive.seed = seed;
  drive.noise = parameters.noise;
  drive.laser_sigma = parameters.laser_sigma;
  drive.truth = drawTruth(parameters, seed);
  return drive;
}

Parameters exactParameters() {
  Parameters parameters = withPrior(10.0);
  for (const Wheel wheel : kAllWheels) parameters.vehicle.metres_per_tick[wheel] = 1e-7;
  return parameters;
}

SimulatedDrive exactDrive(const Parameters& parameters) {
  SimulatedDrive drive;
  drive.rate = 500.0;
  drive.laser_sigma = {0.0, 0.0};
  drive.truth = valuesOf(parameters);
  drive.truth.segment<3>(systematic::kRearRight) << 1.02, 0.99, 1.03;
  return drive;
}

double deviation(const ParameterMatrix& covariance, std::size_t parameter) {
  const auto i = static_cast<Eigen::Index>(parameter);
  return std::sqrt(covariance(i, i));
}

ParameterVector boundOf(const std::string& scenario, const Parameters& parameters) {
  laboratory::DriveSettings settings;
  settings.scenario = scenario;
  settings.rate = 50.0;
  settings.axles = parameters.odometry.axles;
  DriveBound bound(parameters, parametersToEstimate(parameters), priorDeviations(parameters));
  const Eigen::Vector3d sigma(parameters.laser_sigma.position, parameters.laser_sigma.position,
                              parameters.laser_sigma.yaw);
  const Eigen::Matrix3d R = sigma.cwiseAbs2().asDiagonal();
  OdometryPipeline pipeline(toConfiguration(odometryForCalibration(parameters)));
  std::size_t i = 0;
  for (const laboratory::Sample& sample : laboratory::record(parameters.vehicle, settings)) {
    const OdometryUpdate update = laboratory::step(pipeline, sample);
    if (update.step) bound.move(*update.step);
    if (i++ % laboratory::kLaserEvery == 0) bound.update(R);
  }
  return bound.deviations();
}

}  // namespace bs_car_odometry::calibration
