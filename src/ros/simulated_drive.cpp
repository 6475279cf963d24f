#include "bs_car_odometry/ros/simulated_drive.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace bs_car_odometry {

namespace {

constexpr double kSubstep = 0.005;  // s
constexpr double kMaxRate = 10000.0;
constexpr double kWheelDelay = 0.001;     // s, stamp to receipt
constexpr double kSteeringDelay = 0.002;  // s
constexpr double kLaserDelay = 0.003;     // s
constexpr double kSameTime = 1e-9;        // s

void requireRate(const char* name, double rate, bool may_be_zero) {
  if (rate > 0.0 && rate <= kMaxRate) return;
  if (may_be_zero && rate == 0.0) return;
  throw std::invalid_argument(std::string(name) + " must be " + (may_be_zero ? "0 or " : "") +
                              "above 0 and at most 10000 Hz");
}

SimulatedDriveSettings checked(const SimulatedDriveSettings& settings) {
  requireRate("rate", settings.rate, false);
  requireRate("steering rate", settings.steering_rate, true);
  requireRate("laser rate", settings.laser_rate, true);
  if (!(settings.duration >= 0.0)) throw std::invalid_argument("duration must not be negative");
  if (settings.noise_free && settings.draw_gains)
    throw std::invalid_argument("noise-free takes the gains as configured, so they cannot be drawn as well");
  return settings;
}

simulation::Scenario scenarioOf(const Parameters& parameters, const SimulatedDriveSettings& settings) {
  return simulation::makeScenario(settings.scenario, parameters.vehicle,
                                  simulation::drivetrainOf(parameters.vehicle, parameters.odometry.axles),
                                  settings.speed_factor);
}

simulation::TrueParameters truthOf(const Parameters& parameters, const SimulatedDriveSettings& settings) {
  if (settings.noise_free) return simulation::asConfigured(parameters.vehicle);
  if (settings.draw_gains)
    return simulation::drawnFrom(parameters.noise.systematic, parameters.vehicle, settings.seed);
  return simulation::withScenarioGains(parameters.vehicle);
}

simulation::SimulationOptions optionsOf(const Parameters& parameters,
                                        const SimulatedDriveSettings& settings) {
  simulation::SimulationOptions options;
  options.seed = settings.seed;
  options.substep = kSubstep;
  options.drivetrain = simulation::drivetrainOf(parameters.vehicle, parameters.odometry.axles);
  options.initial_pose = {parameters.initial_pose.x, parameters.initial_pose.y, parameters.initial_pose.yaw};
  return options;
}

geometry_msgs::Pose toMessage(const simulation::Pose& pose) {
  geometry_msgs::Pose message;
  message.position.x = pose.x;
  message.position.y = pose.y;
  message.orientation = toQuaternion(pose.yaw);
  return message;
}

}  // namespace

SimulatedDrive::SimulatedDrive(const Parameters& parameters, const SimulatedDriveSettings& settings,
                               Time start)
    : parameters_(parameters),
      settings_(checked(settings)),
      start_(start),
      drivetrain_(simulation::drivetrainOf(parameters.vehicle, parameters.odometry.axles)),
      truth_(truthOf(parameters, settings)),
      duration_(settings.duration > 0.0 ? settings.duration : scenarioOf(parameters, settings).duration),
      car_(parameters.vehicle, truth_,
           settings.noise_free ? std::nullopt : std::optional<NoiseModel>(parameters.noise),
           scenarioOf(parameters, settings), optionsOf(parameters, settings)),
      wheels_{settings.rate},
      steering_{settings.steering_rate > 0.0 ? settings.steering_rate : settings.rate},
      laser_{settings.laser_rate} {
  if (!parameters.laser.frame.empty()) sendLaserMount();
}

double SimulatedDrive::Schedule::next() const {
  return rate > 0.0 ? static_cast<double>(done) / rate : std::numeric_limits<double>::infinity();
}

std::optional<SimulatedMessage> SimulatedDrive::next() {
  for (;;) {
    const double time = std::min({wheels_.next(), steering_.next(), laser_.next()});
    const bool at_end = time > duration_ + kSameTime;
    // What is read from now on is received later than now.
    if (!pending_.empty() && (at_end || pending_.begin()->first <= stamp(time))) {
      SimulatedMessage message = std::move(pending_.begin()->second);
      pending_.erase(pending_.begin());
      return message;
    }
    if (at_end) return std::nullopt;
    car_.advanceTo(time);
    if (wheels_.next() <= time) readWheels();
    if (steering_.next() <= time) {
      if (drivetrain_ == simulation::Drivetrain::kSteered) readSteering(Axle::kFront);
      if (parameters_.vehicle.rear_steering.source == RearSteering::Source::kMeasured)
        readSteering(Axle::kRear);
      ++steering_.done;
    }
    if (laser_.next() <= time) readLaser();
  }
}

void SimulatedDrive::readWheels() {
  const double time = wheels_.next();
  const PerWheel<std::int64_t> counters = car_.readCounters();
  WheelTicks message;
  message.header = header(time, parameters_.base_frame);
  message.front_left = counters[Wheel::kFrontLeft];
  message.front_right = counters[Wheel::kFrontRight];
  message.rear_left = counters[Wheel::kRearLeft];
  message.rear_right = counters[Wheel::kRearRight];
  send(time + kWheelDelay, "wheel_ticks", message);
  if (settings_.truth) sendTruth();
  ++wheels_.done;
}

void SimulatedDrive::readSteering(Axle axle) {
  const double time = steering_.next();
  SteeringAngle message;
  message.header = header(time, parameters_.base_frame);
  message.angle = car_.readSteering(axle);
  send(time + kSteeringDelay, std::string(name(axle)) + "_steering", message);
}

// A pose stamped t shows the car at t - time_offset.
void SimulatedDrive::readLaser() {
  const double time = laser_.next();
  const LaserMount& mount = parameters_.laser;
  const LaserSigma& sigma = parameters_.laser_sigma;
  const double noise = settings_.noise_free ? 0.0 : 1.0;
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header = header(time + mount.time_offset, "map");
  message.pose.pose =
      toMessage(car_.readLaser({mount.x, mount.y, mount.yaw}, noise * sigma.position, noise * sigma.yaw));
  const Eigen::Vector3d sigmas(sigma.position, sigma.position, sigma.yaw);
  message.pose.covariance = toCovariance(sigmas.cwiseAbs2().asDiagonal(), 0.0);
  send(time + std::max(0.0, mount.time_offset) + kLaserDelay, "laser_pose", message);
  ++laser_.done;
}

void SimulatedDrive::sendTruth() {
  nav_msgs::Odometry message;
  message.header = header(car_.time(), parameters_.odom_frame);
  message.child_frame_id = parameters_.base_frame;
  message.pose.pose = toMessage(car_.truePose());
  const simulation::Twist twist = car_.trueTwist();
  message.twist.twist.linear.x = twist.vx;
  message.twist.twist.linear.y = twist.vy;
  message.twist.twist.angular.z = twist.yaw_rate;
  send(car_.time() + kWheelDelay, "ground_truth", message);
}

// Where the laser is to be found in tf: at base_link.
void SimulatedDrive::sendLaserMount() {
  geometry_msgs::TransformStamped mount;
  mount.header = header(0.0, parameters_.base_frame);
  mount.child_frame_id = parameters_.laser.frame;
  mount.transform.rotation.w = 1.0;
  tf2_msgs::TFMessage message;
  message.transforms.push_back(mount);
  send(0.0, "tf_static", message);
}

std_msgs::Header SimulatedDrive::header(double time, const std::string& frame) const {
  std_msgs::Header header;
  header.stamp = toRos(stamp(time));
  header.frame_id = frame;
  return header;
}

void SimulatedDrive::send(double receipt, const std::string& topic, SimulatedMessage::Content content) {
  const Time time = stamp(receipt);
  pending_.emplace(time, SimulatedMessage{time, topic, std::move(content)});
}

std::string describe(const simulation::TrueParameters& truth) {
  std::ostringstream text;
  text.precision(12);
  text << "gains:\n";
  for (Axle axle : kAllAxles) {
    const AxleGains& gains = truth.gains[axle];
    text << "  " << name(axle) << ": {k_r: " << gains.k_r << ", k_l: " << gains.k_l << ", k_b: " << gains.k_b
         << "}\n";
  }
  text << "steering:\n";
  for (Axle axle : kAllAxles)
    text << "  " << name(axle) << ": {scale: " << truth.steering[axle].scale
         << ", offset: " << truth.steering[axle].offset << "}\n";
  return text.str();
}

}  // namespace bs_car_odometry
