#include "bs_car_odometry/ros/odometry_diagnostics.hpp"

#include "bs_car_odometry/ros/fault_sentences.hpp"
#include "bs_car_odometry/ros/verdicts.hpp"

#include <boost/date_time/posix_time/posix_time.hpp>

#include <algorithm>

namespace bs_car_odometry {

namespace {

using Level = diagnostic_msgs::DiagnosticStatus;

/// The updater drops the first letter, as of a node's name.
constexpr const char* kUpdaterName = "/bs_car_odometry";
constexpr double kReportPeriod = 1.0;        // [s], REP-107
constexpr double kSilenceIsError = 0.5;      // [s] without wheel messages
constexpr double kUnknownSteeringAge = 1.0;  // [s]

}  // namespace

OdometryDiagnostics::OdometryDiagnostics(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                                         const OdometryPipeline& pipeline, const std::string& vehicle)
    : pipeline_(pipeline),
      updater_(node, private_node, kUpdaterName),
      started_(boost::posix_time::to_iso_extended_string(ros::WallTime::now().toBoost()) + " UTC") {
  updater_.setHardwareID(vehicle.empty() ? "none" : vehicle);
  updater_.add("Encoders", this, &OdometryDiagnostics::encoders);
  updater_.add("Steering", this, &OdometryDiagnostics::steering);
  updater_.add("Clock", this, &OdometryDiagnostics::clock);
  updater_.add("Calibration", this, &OdometryDiagnostics::calibration);
  updater_.add("Output", this, &OdometryDiagnostics::output);
  // Wall time: a simulated clock that stands still is among what must be reported.
  timer_ = node.createWallTimer(ros::WallDuration(kReportPeriod),
                                [this](const ros::WallTimerEvent&) { report(); });
}

void OdometryDiagnostics::report() {
  updater_.force_update();
  reported_ = pipeline_.counts();
  rival_transform_.clear();
  master_.warn();
}

void OdometryDiagnostics::add(Status& status, unsigned char level, Verdict verdict) const {
  const std::uint64_t times = since(verdict);
  // A reset starts the counts again.
  if (times == 0 || pipeline_.counts()[verdict] < reported_[verdict]) return;
  status.mergeSummary(level, std::to_string(times) + " dropped: " + explain(verdict, pipeline_.counts()));
}

void OdometryDiagnostics::addFault(Status& status, std::size_t sensor) const {
  const SensorState& state = sensors_.sensors[sensor];
  if (state.fault != SensorFault::kNone) status.mergeSummary(level(state), explain(sensor, state));
}

void OdometryDiagnostics::encoders(Status& status) {
  status.summary(Level::OK, "wheel messages arrive");
  if (newest_wheels_.isZero()) {
    status.summary(Level::ERROR,
                   "no wheel message yet: is the driver running, and its topic remapped to this node?");
  } else if (const double silence = (ros::SteadyTime::now() - newest_wheels_).toSec();
             silence > kSilenceIsError) {
    status.summary(Level::ERROR,
                   "no wheel message for " + std::to_string(silence) + " s: is the driver running?");
  }
  for (const Wheel wheel : kAllWheels) addFault(status, sensor(wheel));
  status.mergeSummary(sensors_.determined ? Level::OK : Level::ERROR, explainUndetermined(sensors_));
  if (since(Verdict::kRivalPublisher) > 0)
    status.mergeSummary(Level::ERROR, rival_input_ + ": " + explain(Verdict::kRivalPublisher));
  add(status, Level::WARN, Verdict::kImplausible);
  add(status, Level::WARN, Verdict::kOverflow);
  if (pipeline_.counts().wheel_jumps > reported_.wheel_jumps)
    status.mergeSummary(Level::WARN,
                        "the counter of a wheel jumped further than 'max_speed' allows and was "
                        "left out: check its encoder and cable");
  if (pipeline_.counts().counter_restarts > reported_.counter_restarts)
    status.mergeSummary(Level::WARN,
                        "the counters jumped and were taken as a new reference: was the driver restarted?");
  if (pipeline_.counts().ambiguous_gaps > reported_.ambiguous_gaps)
    status.mergeSummary(Level::ERROR, explainAmbiguousGap());
  status.add("wheel messages", pipeline_.counts().wheel_messages);
}

void OdometryDiagnostics::steering(Status& status) {
  const PerAxle<bool>& needed = pipeline_.steeringNeeded();
  if (!needed.front && !needed.rear) return status.summary(Level::OK, "not needed by this configuration");
  status.summary(Level::OK, "steering angles arrive");
  for (const Axle axle : kAllAxles)
    if (needed[axle] && !pipeline_.hasSteering(axle))
      status.mergeSummary(Level::ERROR, std::string("waiting for steering: no angle on ") + name(axle) +
                                            "_steering yet; is it published, and remapped to this node?");
  for (const Axle axle : kAllAxles) addFault(status, sensor(axle));
  if (state_ == OdometryState::kNoSteering) {
    // From then on the angle may be anywhere in its range (S4).
    const bool unknown = std::max(steering_age_.front, steering_age_.rear) > kUnknownSteeringAge;
    status.mergeSummary(unknown ? Level::ERROR : Level::WARN, explain(state_));
  }
  add(status, Level::WARN, Verdict::kNotFinite);
  add(status, Level::WARN, Verdict::kSteeringLimit);
  status.add("steering messages", pipeline_.counts().steering_messages);
  status.add("steps on a held angle", pipeline_.counts().steering_held);
}

void OdometryDiagnostics::clock(Status& status) {
  status.summary(Level::OK, "stamps are in order");
  if (ros::Time::now().isZero())
    status.mergeSummary(Level::ERROR, "waiting for /clock: use_sim_time is set, and nothing publishes it");
  add(status, Level::ERROR, Verdict::kStampZero);
  add(status, Level::ERROR, Verdict::kStampInvalid);
  add(status, Level::WARN, Verdict::kFuture);
  add(status, Level::WARN, Verdict::kOutOfOrder);
  add(status, Level::WARN, Verdict::kRepeated);
  if (pipeline_.counts().gaps > reported_.gaps)
    status.mergeSummary(
        Level::WARN,
        "an interval between wheel messages was longer than 'max_gap': is the driver overloaded?");
}

void OdometryDiagnostics::calibration(Status& status) {
  status.summary(calibration_level_, calibration_text_);
  const OdometryCalibration in_use = pipeline_.calibration();
  for (const Axle axle : kAllAxles) {
    const std::string prefix = std::string(name(axle)) + "/";
    status.add(prefix + "k_r", in_use.gains[axle].k_r);
    status.add(prefix + "k_l", in_use.gains[axle].k_l);
    status.add(prefix + "k_b", in_use.gains[axle].k_b);
    status.add(prefix + "steering_scale", in_use.steering[axle].scale);
    status.add(prefix + "steering_offset", in_use.steering[axle].offset);
  }
}

void OdometryDiagnostics::output(Status& status) {
  status.summary(Level::OK,
                 pipeline_.started() ? "odometry is published" : "waiting for the first wheel message");
  status.add("started", started_);
  if (pipeline_.counts().refused_states > reported_.refused_states)
    status.mergeSummary(Level::ERROR, explain(OdometryState::kDegraded));
  if (pipeline_.counts().covariance_repairs > reported_.covariance_repairs)
    status.mergeSummary(Level::WARN, explainRepair());
  master_.addTo(status);
  if (!rival_transform_.empty()) status.mergeSummary(Level::WARN, rival_transform_);
}

FailureReport::FailureReport(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                             const std::string& reason)
    : updater_(node, private_node, kUpdaterName) {
  updater_.setHardwareID("none");
  updater_.add("Output", [reason](diagnostic_updater::DiagnosticStatusWrapper& status) {
    status.summary(Level::ERROR, "does not run. " + reason);
  });
  timer_ = node.createWallTimer(ros::WallDuration(kReportPeriod),
                                [this](const ros::WallTimerEvent&) { updater_.force_update(); });
}

}  // namespace bs_car_odometry
