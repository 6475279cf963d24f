#include "bs_car_odometry/ros/calibration_diagnostics.hpp"

#include "bs_car_odometry/calibration/observability.hpp"

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace bs_car_odometry {

using calibration::CalibrationStage;
using calibration::implausibleGains;
using calibration::Knowledge;
using calibration::LaserVerdict;

namespace {

using Level = diagnostic_msgs::DiagnosticStatus;

/// The updater drops the first letter, as of a node's name.
constexpr const char* kUpdaterName = "/bs_car_odometry";
constexpr double kReportPeriod = 1.0;  // [s], REP-107
constexpr double kWheelSilence = 0.5;  // [s] without wheel messages
constexpr double kLaserSilence = 2.0;  // [s] without laser poses; localisers are slower than wheels

bool isRejected(double nis) { return nis > calibration::kRejectLimit; }

double silenceSince(const ros::SteadyTime& newest) { return (ros::SteadyTime::now() - newest).toSec(); }

std::string text(const char* format, double value) {
  std::array<char, 160> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

}  // namespace

void InnovationMonitor::add(const calibration::Innovation& innovation) {
  nis_[count_ % kPoses] = innovation.nis;
  ++count_;
}

std::size_t InnovationMonitor::rejected() const {
  return static_cast<std::size_t>(std::count_if(nis_.begin(), nis_.begin() + filled(), isRejected));
}

double InnovationMonitor::mean() const {
  const double sum =
      std::accumulate(nis_.begin(), nis_.begin() + filled(), 0.0,
                      [](double so_far, double nis) { return isRejected(nis) ? so_far : so_far + nis; });
  return sum / static_cast<double>(std::max<std::size_t>(static_cast<std::size_t>(filled()) - rejected(), 1));
}

std::string InnovationMonitor::verdict() const {
  if (count_ < kPoses) return {};
  if (static_cast<double>(rejected()) > kMostRejected * static_cast<double>(kPoses))
    return std::to_string(rejected()) +
           " of the latest 100 laser poses are outliers: does the localiser jump, is laser/x, y, yaw right?";
  if (mean() > kLargestMean)
    return text(
        "the laser poses scatter more than expected (mean NIS %.2f, expected 3): raise 'noise' or the "
        "laser's covariance, or estimate laser/time_offset",
        mean());
  if (mean() < kLeastMean)
    return text(
        "the laser poses scatter less than expected (mean NIS %.2f, expected 3): the laser's "
        "covariance or 'noise' is too large",
        mean());
  return {};
}

CalibrationDiagnostics::CalibrationDiagnostics(const ros::NodeHandle& node,
                                               const ros::NodeHandle& private_node,
                                               const CalibrationAdapter& adapter)
    : adapter_(adapter), updater_(node, private_node, kUpdaterName) {
  const std::string& vehicle = adapter.parameters().vehicle.name;
  updater_.setHardwareID(vehicle.empty() ? "none" : vehicle);
  updater_.add("Calibration", this, &CalibrationDiagnostics::calibration);
  updater_.add("Laser", this, &CalibrationDiagnostics::laser);
  // Wall time: a simulated clock that stands still is among what must be reported.
  timer_ = node.createWallTimer(ros::WallDuration(kReportPeriod),
                                [this](const ros::WallTimerEvent&) { report(); });
}

void CalibrationDiagnostics::note(const calibration::CalibrationUpdate& update) {
  innovations_.add(update.innovation);
  if (!update.jump) return;
  jump_ = explain(*update.jump);
  jump_reported_ = false;
}

void CalibrationDiagnostics::noteStart() {
  innovations_.clear();
  jump_.clear();
  jump_reported_ = true;
}

void CalibrationDiagnostics::report() {
  updater_.force_update();
  reported_ = adapter_.laserCounts();
  jump_reported_ = true;
  master_.warn();
}

void CalibrationDiagnostics::calibration(Status& status) {
  const calibration::Calibrator& calibrator = adapter_.calibrator();
  const Knowledge knowledge = knowledgeOf(calibrator);
  switch (calibrator.stage()) {
    case CalibrationStage::kStart:
      status.summary(Level::OK, "waiting for the first laser poses that agree with each other");
      break;
    case CalibrationStage::kRunning:
      status.summary(Level::OK, "running; " + missing(knowledge));
      break;
    case CalibrationStage::kConverged:
      status.summary(Level::OK, "converged: every gain is observed");
      break;
  }
  if (newest_wheels_.isZero() || silenceSince(newest_wheels_) > kWheelSilence)
    status.mergeSummary(Level::ERROR,
                        "no wheel message: is the driver running, and its topic remapped to this node?");
  for (const Axle axle : kAllAxles)
    if (adapter_.pipeline().steeringNeeded()[axle] && !adapter_.pipeline().hasSteering(axle))
      status.mergeSummary(Level::ERROR, std::string("waiting for steering: no angle on ") + name(axle) +
                                            "_steering yet; is it published, and remapped to this node?");
  const std::string implausible = implausibleGains(calibrator.estimate().values, calibrator.observed());
  if (!implausible.empty()) status.mergeSummary(Level::ERROR, implausible);
  const std::string inconsistent = innovations_.verdict();
  if (!inconsistent.empty()) status.mergeSummary(Level::WARN, inconsistent);
  if (!output_fault_.empty()) status.mergeSummary(Level::WARN, output_fault_);
  master_.addTo(status);
  addProgress(status);
}

void CalibrationDiagnostics::addProgress(Status& status) const {
  const calibration::Calibrator& calibrator = adapter_.calibrator();
  const Knowledge knowledge = knowledgeOf(calibrator);
  const calibration::ParameterVector values = calibrator.estimate().values;
  for (std::size_t i = 0; i < calibration::kCount; ++i) {
    if (!knowledge.estimated[i]) continue;
    const auto k = static_cast<Eigen::Index>(i);
    std::array<char, 96> line{};
    std::snprintf(line.data(), line.size(), "%.5f +/- %.5f, %.0f %%%s", values[k], knowledge.deviation[k],
                  100.0 * progress(knowledge, i), knowledge.observed(i) ? ", observed" : "");
    status.add(calibration::parameterName(i), std::string(line.data()));
  }
  status.add("distance", text("%.1f m", knowledge.excitation.distance));
  status.add("mean NIS of 100 laser poses", innovations_.mean());
}

void CalibrationDiagnostics::laser(Status& status) {
  status.summary(Level::OK, "laser poses arrive");
  if (newest_laser_.isZero()) {
    status.summary(Level::WARN,
                   "no laser pose yet: is the localiser running, and its topic remapped to laser_pose?");
  } else if (const double silence = silenceSince(newest_laser_); silence > kLaserSilence) {
    status.summary(Level::WARN, text("no laser pose for %.0f s: is the localiser running?", silence));
  }
  if (!adapter_.mountKnown()) status.mergeSummary(Level::ERROR, adapter_.waitingForMount(ros::Time::now()));
  const LaserInputCounts& counts = adapter_.laserCounts();
  if (counts.without_covariance > reported_.without_covariance)
    status.mergeSummary(Level::WARN, "the laser poses carry no covariance: 'laser_sigma' is used instead");
  if (!jump_reported_) status.mergeSummary(Level::WARN, jump_);
  addDrops(status);
  status.add("laser poses", counts.messages);
  status.add("used", adapter_.calibrator().counts().used);
  status.add("rejected", adapter_.calibrator().counts().rejected);
  status.add("jumps of the localiser", adapter_.calibrator().counts().relocalisations);
  status.add("latest jump", jump_.empty() ? "none" : jump_);
}

void CalibrationDiagnostics::addDrops(Status& status) const {
  const LaserInputCounts& counts = adapter_.laserCounts();
  for (std::size_t i = 1; i < counts.verdicts.size(); ++i) {
    const auto verdict = static_cast<LaserVerdict>(i);
    if (verdict == LaserVerdict::kNoMount || counts[verdict] <= reported_[verdict]) continue;
    status.mergeSummary(
        Level::WARN, std::to_string(counts[verdict] - reported_[verdict]) + " dropped: " + explain(verdict));
  }
}

}  // namespace bs_car_odometry
