#include "drive.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace bs_car_odometry::drives {

namespace {

double distance(const OdometryEstimate& estimate, const simulation::Pose& truth) {
  return std::hypot(estimate.pose.x - truth.x, estimate.pose.y - truth.y);
}

}  // namespace

MotionEstimate motionBetween(const OdometryConfiguration& configuration, const std::vector<Sample>& drive,
                             std::size_t from, std::size_t to, std::size_t every) {
  using laboratory::stampOf;
  OdometryPipeline pipeline(configuration);
  for (std::size_t i = 0; i < drive.size(); i += every) laboratory::step(pipeline, drive[i]);
  const auto motion = pipeline.motionHistory().between(stampOf(drive.at(from)), stampOf(drive.at(to)));
  if (!motion) throw std::logic_error("the motion between two samples is not known");
  return *motion;
}

simulation::Pose trueMotion(const std::vector<Sample>& drive, std::size_t from, std::size_t to) {
  const simulation::Pose& a = drive.at(from).truth;
  const simulation::Pose& b = drive.at(to).truth;
  const double c = std::cos(a.yaw);
  const double s = std::sin(a.yaw);
  return {c * (b.x - a.x) + s * (b.y - a.y), c * (b.y - a.y) - s * (b.x - a.x), b.yaw - a.yaw};
}

OdometryEstimate endOf(const OdometryConfiguration& configuration, const std::vector<Sample>& drive) {
  OdometryEstimate end;
  replay(configuration, drive,
         [&end](const Sample&, const OdometryUpdate& update) { end = update.estimate; });
  return end;
}

Departure departure(const OdometryConfiguration& configuration, const std::vector<Sample>& drive) {
  Departure departure;
  replay(configuration, drive, [&](const Sample& sample, const OdometryUpdate& update) {
    departure.at_end = distance(update.estimate, sample.truth);
    departure.largest = std::max(departure.largest, departure.at_end);
  });
  return departure;
}

OdometryConfiguration odometryOf(const Vehicle& vehicle, AxleSelection axles) {
  OdometryConfiguration configuration;
  configuration.vehicle = vehicle;
  configuration.options.axles = axles;
  return configuration;
}

const char* name(AxleSelection axles) {
  switch (axles) {
    case AxleSelection::kBoth:
      return "both";
    case AxleSelection::kFront:
      return "front";
    case AxleSelection::kRear:
      return "rear";
  }
  return "";
}

const char* name(AxleGeometry geometry) {
  return geometry == AxleGeometry::kAckermann ? "ackermann" : "pivot";
}

}  // namespace bs_car_odometry::drives
