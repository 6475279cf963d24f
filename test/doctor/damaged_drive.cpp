#include "damaged_drive.hpp"

#include "../../src/tools/bag_writer.hpp"

#include "bs_car_odometry/ros/conversions.hpp"

#include <sstream>

namespace bs_car_odometry::tools::testing {

namespace {

constexpr double kStart = 1.6e9;  // s

template <typename Message>
Damage on(const std::function<bool(Message&)>& damage, const std::string& topic_end) {
  return [=](SimulatedMessage& message) {
    auto* content = std::get_if<Message>(&message.content);
    const bool meant =
        message.topic.size() >= topic_end.size() &&
        message.topic.compare(message.topic.size() - topic_end.size(), std::string::npos, topic_end) == 0;
    return content == nullptr || !meant || damage(*content);
  };
}

template <typename Choice>
std::string lines(const doctor::Findings& findings, const Choice& chosen) {
  doctor::Findings some;
  for (const doctor::Finding& finding : findings)
    if (chosen(finding)) some.push_back(finding);
  std::ostringstream text;
  doctor::print(some, text);
  return text.str();
}

}  // namespace

Parameters cycab() {
  Parameters parameters;
  parameters.vehicle.name = "cycab";
  parameters.vehicle.wheelbase = 1.2;
  parameters.vehicle.track = {1.2, 1.2};
  parameters.vehicle.metres_per_tick = {{1e-4, 1e-4, 1e-4, 1e-4}};
  return parameters;
}

Parameters frontSteered() {
  Parameters parameters = cycab();
  parameters.vehicle.rear_steering.coefficients = {0.0};
  return parameters;
}

Parameters differential() {
  Parameters parameters = frontSteered();
  parameters.vehicle.wheelbase = 0.4;
  parameters.vehicle.track = {0.4, 0.4};
  parameters.vehicle.metres_per_tick = {{0.0, 0.0, 1e-4, 1e-4}};
  parameters.odometry.axles = AxleSelection::kRear;
  return parameters;
}

Damage onWheels(const std::function<bool(WheelTicks&)>& damage) {
  return on<WheelTicks>(damage, "wheel_ticks");
}

Damage onSteering(const std::function<bool(SteeringAngle&)>& damage) {
  return on<SteeringAngle>(damage, "steering");
}

Damage onLaser(const std::function<bool(geometry_msgs::PoseWithCovarianceStamped&)>& damage) {
  return on<geometry_msgs::PoseWithCovarianceStamped>(damage, "laser_pose");
}

void recordDrive(const std::string& path, const Parameters& parameters,
                 const SimulatedDriveSettings& settings, const Damage& damage) {
  SimulatedDrive drive(parameters, settings, Time(durationFromSeconds(kStart)));
  BagWriter bag(path);
  while (std::optional<SimulatedMessage> message = drive.next()) {
    if (damage && !damage(*message)) continue;
    const ros::Time receipt = toRos(message->receipt);
    std::visit([&](const auto& content) { bag.write("/" + message->topic, receipt, content); },
               message->content);
  }
  bag.commit();
}

doctor::Examination Patient::examine(const Parameters& configured, const Damage& damage,
                                     const TopicNames& names) const {
  const TemporaryFolder folder;
  recordDrive(folder.file("drive.bag"), parameters_, settings_, damage);
  return doctor::examine(folder.file("drive.bag"), configured, names);
}

std::string troubles(const doctor::Examination& examination) {
  return lines(examination.findings,
               [](const doctor::Finding& finding) { return finding.severity != doctor::Severity::kOk; });
}

std::string errors(const doctor::Examination& examination) {
  return lines(examination.findings,
               [](const doctor::Finding& finding) { return finding.severity == doctor::Severity::kError; });
}

std::string report(const doctor::Examination& examination) {
  return lines(examination.findings, [](const doctor::Finding&) { return true; });
}

}  // namespace bs_car_odometry::tools::testing
