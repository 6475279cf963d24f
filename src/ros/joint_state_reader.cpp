#include "bs_car_odometry/ros/joint_state_reader.hpp"

#include "bs_car_odometry/core/kinematics.hpp"

namespace bs_car_odometry {

namespace {

/// Mean angle of an axle over its wheels' own directions, the other axle being at `other`.
double meanAxleAngle(const Vehicle& vehicle, Axle axle, const std::vector<double>& directions, double other) {
  if (directions.size() == 1) return directions.front();
  return 0.5 * (axleAngle(vehicle, leftWheel(axle), directions[0], other) +
                axleAngle(vehicle, rightWheel(axle), directions[1], other));
}

std::optional<std::vector<double>> directionsOf(const std::vector<std::string>& joints,
                                                const JointPositions& positions) {
  std::vector<double> directions;
  for (const std::string& joint : joints) {
    const std::optional<double> position = positions[joint];
    if (!position) return std::nullopt;
    directions.push_back(*position);
  }
  if (directions.empty()) return std::nullopt;
  return directions;
}

}  // namespace

std::optional<double> JointPositions::operator[](const std::string& joint) const {
  for (const auto& [name, position] : positions)
    if (name == joint) return position;
  return std::nullopt;
}

std::optional<JointPositions> readJointState(const RawJointState& message) {
  ByteReader reader(message.bytes);
  JointPositions joints;
  reader.value<std::uint32_t>();  // header.seq
  joints.stamp.sec = reader.value<std::uint32_t>();
  joints.stamp.nsec = reader.value<std::uint32_t>();
  reader.string();  // header.frame_id
  const std::uint32_t names = reader.count(sizeof(std::uint32_t));
  joints.positions.resize(names);
  for (auto& joint : joints.positions) joint.first = reader.string();
  if (reader.count(sizeof(double)) != names) return std::nullopt;
  for (auto& joint : joints.positions) joint.second = reader.value<double>();
  if (!reader.sound()) return std::nullopt;
  return joints;
}

PerAxle<std::optional<double>> axleReadings(const Vehicle& vehicle, const JointNames& joints,
                                            const JointPositions& positions) {
  PerAxle<std::optional<double>> readings;
  PerAxle<std::optional<std::vector<double>>> directions;
  for (const Axle axle : kAllAxles) {
    directions[axle] = directionsOf(joints.steering[axle], positions);
    if (directions[axle]) readings[axle] = meanAxleAngle(vehicle, axle, *directions[axle], 0.0);
  }
  const auto angle = [&](Axle axle) {
    return vehicle.steering[axle].scale * readings[axle].value_or(0.0) + vehicle.steering[axle].offset;
  };
  // A wheel's direction depends on both axles' angles; each round brings the other axle closer by about
  // track/wheelbase times the angle, so that a few rounds reach rounding error.
  const bool polynomial = vehicle.rear_steering.source == RearSteering::Source::kPolynomial;
  for (int round = 0; round < 30; ++round) {
    const double front = angle(Axle::kFront);
    const double rear = polynomial ? vehicle.rear_steering.angle(front) : angle(Axle::kRear);
    if (directions.front) readings.front = meanAxleAngle(vehicle, Axle::kFront, *directions.front, rear);
    if (directions.rear) readings.rear = meanAxleAngle(vehicle, Axle::kRear, *directions.rear, front);
  }
  return readings;
}

}  // namespace bs_car_odometry
