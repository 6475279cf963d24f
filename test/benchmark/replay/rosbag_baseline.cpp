// What rosbag alone takes: reading the inputs of odometry and calibration from a bag, or writing its outputs
// to one. The time of that and nothing else is printed, in seconds of the wall clock and of the processor.
#include "bs_car_odometry/OdometryStatus.h"
#include "bs_car_odometry/SteeringAngle.h"
#include "bs_car_odometry/WheelTicks.h"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <exception>
#include <string>
#include <variant>
#include <vector>

namespace bs_car_odometry::benchmarks {
namespace {

class Stopwatch {
 public:
  void start() {
    wall_start_ = std::chrono::steady_clock::now();
    processor_start_ = std::clock();
  }
  void stop() {
    wall_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start_).count();
    processor_ += static_cast<double>(std::clock() - processor_start_) / CLOCKS_PER_SEC;
  }
  void print() const { std::printf("%.6f %.6f\n", wall_, processor_); }

 private:
  std::chrono::steady_clock::time_point wall_start_;
  std::clock_t processor_start_{0};
  double wall_{0.0};
  double processor_{0.0};
};

/// Opens the bag and makes every message of the input topics.
void readInputs(const std::string& path) {
  Stopwatch stopwatch;
  stopwatch.start();
  std::int64_t sum = 0;  // so that nothing is optimised away
  {
    rosbag::Bag bag(path, rosbag::bagmode::Read);
    rosbag::View view(
        bag, rosbag::TopicQuery({"/wheel_ticks", "/front_steering", "/rear_steering", "/laser_pose"}));
    for (const rosbag::MessageInstance& message : view) {
      if (const auto ticks = message.instantiate<WheelTicks>())
        sum += ticks->rear_left;
      else if (const auto angle = message.instantiate<SteeringAngle>())
        sum += angle->header.stamp.nsec;
      else if (const auto pose = message.instantiate<geometry_msgs::PoseWithCovarianceStamped>())
        sum += pose->header.stamp.nsec;
    }
  }
  stopwatch.stop();
  stopwatch.print();
  std::fprintf(stderr, "%lld\n", static_cast<long long>(sum));
}

struct Output {
  std::string topic;
  ros::Time time;
  std::variant<nav_msgs::Odometry::ConstPtr, tf2_msgs::TFMessage::ConstPtr, OdometryStatus::ConstPtr> message;
};

Output toOutput(const rosbag::MessageInstance& message) {
  Output output{message.getTopic(), message.getTime(), {}};
  if (const auto odom = message.instantiate<nav_msgs::Odometry>())
    output.message = odom;
  else if (const auto transform = message.instantiate<tf2_msgs::TFMessage>())
    output.message = transform;
  else
    output.message = message.instantiate<OdometryStatus>();
  return output;
}

/// Writes the messages of a bag that replay_bag wrote to another, from memory, some thousands at a time.
void writeOutputs(const std::string& from, const std::string& to) {
  constexpr std::size_t kBatch = 9000;
  rosbag::Bag source(from, rosbag::bagmode::Read);
  rosbag::View view(source);
  Stopwatch stopwatch;
  stopwatch.start();
  rosbag::Bag bag(to, rosbag::bagmode::Write);
  bag.setCompression(rosbag::compression::LZ4);
  stopwatch.stop();
  std::vector<Output> batch;
  const auto write = [&] {
    stopwatch.start();
    for (const Output& output : batch)
      std::visit([&](const auto& message) { bag.write(output.topic, output.time, *message); },
                 output.message);
    stopwatch.stop();
    batch.clear();
  };
  for (const rosbag::MessageInstance& message : view) {
    batch.push_back(toOutput(message));
    if (batch.size() == kBatch) write();
  }
  write();
  stopwatch.start();
  bag.close();
  stopwatch.stop();
  stopwatch.print();
}

}  // namespace
}  // namespace bs_car_odometry::benchmarks

int main(int argc, char** argv) {
  using namespace bs_car_odometry::benchmarks;
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  try {
    if (arguments.size() == 2 && arguments[0] == "read") {
      readInputs(arguments[1]);
    } else if (arguments.size() == 3 && arguments[0] == "write") {
      writeOutputs(arguments[1], arguments[2]);
    } else {
      std::fprintf(stderr, "usage: rosbag_baseline read IN.bag | write FROM.bag TO.bag\n");
      return 1;
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rosbag_baseline: %s\n", error.what());
    return 1;
  }
  return 0;
}
