#include "csv_recording.hpp"

#include "csv_table.hpp"
#include "tool.hpp"
#include "wheel_counters_from_csv.hpp"

#include <ros/time.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>

namespace bs_car_odometry::tools {
namespace {

constexpr double kEarliestBegin = 1e6;      // [s]: what begins earlier counts from the start of its recording
constexpr std::int64_t kMove = 1600000000;  // [s]
constexpr double kSameClock = 1e6;          // [s]: files of one recording begin no further apart
constexpr std::int64_t kNanoseconds = 1000000000;
constexpr std::int64_t kTimeEnd = 4294967296;  // [s]: ros::Time keeps the seconds in 32 bits

/// Stamps of a recording's rows.
class Stamps {
 public:
  explicit Stamps(bool moved) : move_(moved ? kMove : 0) {}

  ros::Time of(const CsvTable& table, std::size_t row) const {
    const double t = table["t"][row];
    const double limit = static_cast<double>(kTimeEnd);
    // The move is added in whole nanoseconds: at 1.6e9 s a double resolves only 0.2 us.
    const std::int64_t stamp =
        std::abs(t) < limit ? std::llround(t * 1e9) + move_ * kNanoseconds : std::int64_t{-1};
    if (stamp <= 0 || stamp >= kTimeEnd * kNanoseconds)
      throw InputError(table.place(row) + ": " + std::to_string(t) + " s is no time that ROS knows");
    return ros::Time(static_cast<std::uint32_t>(stamp / kNanoseconds),
                     static_cast<std::uint32_t>(stamp % kNanoseconds));
  }

 private:
  std::int64_t move_;
};

using Table = std::unique_ptr<CsvTable>;

double begin(const Table& table) { return (*table)["t"].front(); }

Stamps stampsOf(const std::vector<const Table*>& tables) {
  const CsvTable& wheels = **tables.front();
  bool moved = false;
  for (const Table* table : tables) {
    if (*table == nullptr) continue;
    if (std::abs(begin(*table) - wheels["t"].front()) > kSameClock)
      throw InputError((*table)->path() + " and " + wheels.path() + " do not begin on the same clock");
    moved = moved || begin(*table) < kEarliestBegin;
  }
  return Stamps(moved);
}

void requireColumns(const CsvTable& table, const std::vector<std::string>& columns,
                    const std::string& expected) {
  const auto missing = std::find_if(columns.begin(), columns.end(),
                                    [&](const std::string& column) { return !table.has(column); });
  if (missing != columns.end())
    throw InputError(table.path() + ": the column '" + *missing + "' is missing; expected: " + expected);
}

Table readWheels(const std::string& path) {
  auto table = std::make_unique<CsvTable>(path, std::vector<std::string>{"fl", "fr", "rl", "rr"});
  if (!table->has("fl") && !table->has("fr") && !table->has("rl") && !table->has("rr"))
    throw InputError(path + ": no column of a wheel; known: fl, fr, rl, rr");
  return table;
}

Table readSteering(const std::string& path) {
  if (path.empty()) return nullptr;
  const char* const kExpected = "t, angle or t, front, rear";
  auto table = std::make_unique<CsvTable>(path, std::vector<std::string>{"angle", "front", "rear"});
  if (!table->has("angle")) {
    requireColumns(*table, {"front", "rear"}, kExpected);
  } else if (table->has("front") || table->has("rear")) {
    throw InputError(path + ": 'angle' beside 'front' or 'rear'; expected: " + std::string(kExpected));
  }
  return table;
}

Table readPoses(const std::string& path) {
  if (path.empty()) return nullptr;
  auto table = std::make_unique<CsvTable>(path, std::vector<std::string>{"x", "y", "yaw"});
  requireColumns(*table, {"x", "y", "yaw"}, "t, x, y, yaw");
  return table;
}

std::vector<WheelTicks> wheelMessages(const CsvTable& table, const Stamps& stamps, const CsvSource& source) {
  std::vector<WheelTicks> messages(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) messages[row].header.stamp = stamps.of(table, row);
  const std::pair<const char*, std::int64_t WheelTicks::*> columns[] = {{"fl", &WheelTicks::front_left},
                                                                        {"fr", &WheelTicks::front_right},
                                                                        {"rl", &WheelTicks::rear_left},
                                                                        {"rr", &WheelTicks::rear_right}};
  for (const auto& [column, counter] : columns) {
    if (!table.has(column)) continue;  // the counter stays 0
    const std::vector<std::int64_t> counters = countersFromCsv(table, column, source);
    for (std::size_t row = 0; row < table.rows(); ++row) messages[row].*counter = counters[row];
  }
  return messages;
}

std::vector<SteeringAngle> steeringMessages(const CsvTable& table, const std::string& column,
                                            const Stamps& stamps, const CsvSource& source) {
  if (!table.has(column)) return {};
  std::vector<SteeringAngle> messages(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    messages[row].header.stamp = stamps.of(table, row);
    messages[row].angle = table[column][row] * source.radians_per_unit / source.steering_ratio;
  }
  return messages;
}

geometry_msgs::Pose planarPose(double x, double y, double yaw) {
  geometry_msgs::Pose pose;
  pose.position.x = x;
  pose.position.y = y;
  pose.orientation.z = std::sin(yaw / 2.0);
  pose.orientation.w = std::cos(yaw / 2.0);
  return pose;
}

/// Poses twice: as a laser localiser gives them and as the truth. Covariances are 0, "not known"; so is the
/// twist of the truth, since differences of noisy poses would pass for a measurement.
void addPoses(const CsvTable& table, const Stamps& stamps, Recording& recording) {
  for (std::size_t row = 0; row < table.rows(); ++row) {
    geometry_msgs::PoseWithCovarianceStamped laser_pose;
    laser_pose.header.stamp = stamps.of(table, row);
    laser_pose.header.frame_id = "map";
    laser_pose.pose.pose = planarPose(table["x"][row], table["y"][row], table["yaw"][row]);
    nav_msgs::Odometry truth;
    truth.header.stamp = laser_pose.header.stamp;
    truth.header.frame_id = "odom";
    truth.child_frame_id = "base_link";
    truth.pose = laser_pose.pose;
    recording.laser_poses.push_back(laser_pose);
    recording.ground_truth.push_back(truth);
  }
}

}  // namespace

WheelUnit wheelUnit(const std::string& name) {
  const std::map<std::string, WheelUnit> units{{"ticks", WheelUnit::kTicks},
                                               {"tick_increments", WheelUnit::kTickIncrements},
                                               {"m/s", WheelUnit::kMetresPerSecond},
                                               {"rpm", WheelUnit::kRpm},
                                               {"rad/s", WheelUnit::kRadiansPerSecond}};
  const auto unit = units.find(name);
  if (unit == units.end())
    throw InputError("--wheel-unit '" + name +
                     "' is not known; known: ticks, tick_increments, m/s, rpm, rad/s");
  return unit->second;
}

Recording readRecording(const CsvSource& source) {
  const Table wheels = readWheels(source.wheels_file);
  const Table steering = readSteering(source.steering_file);
  const Table poses = readPoses(source.pose_file);
  const Stamps stamps = stampsOf({&wheels, &steering, &poses});
  Recording recording;
  recording.wheels = wheelMessages(*wheels, stamps, source);
  if (steering != nullptr) {
    const std::string front = steering->has("angle") ? "angle" : "front";
    recording.front_steering = steeringMessages(*steering, front, stamps, source);
    recording.rear_steering = steeringMessages(*steering, "rear", stamps, source);
  }
  if (poses != nullptr) addPoses(*poses, stamps, recording);
  return recording;
}

}  // namespace bs_car_odometry::tools
