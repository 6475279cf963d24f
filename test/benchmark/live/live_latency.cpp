// Latency of the odometry nodelet against a nodelet that only copies the message, in one manager: from
// publishing wheel ticks to receiving `odom`. Two identical copies are the control: where they differ, the
// machine is too busy.
#include "copy_nodelet.hpp"
#include "latency_probe.hpp"

#include <nodelet/loader.h>
#include <ros/ros.h>
#include <pluginlib/class_loader.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace bs_car_odometry::benchmarks {
namespace {

constexpr double kMedianLimit = 1.25;
constexpr double kTailLimit = 1.2;
constexpr double kControlLimit = 1.1;

enum class Outcome { kPass, kFail, kInconclusive };

double percentile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0.0;
  const auto n = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + n, values.end());
  return values[static_cast<std::size_t>(n)];
}

/// One percentile of several runs: each run's latencies, and their ratios to those of the copy.
struct Comparison {
  double fraction;
  std::array<std::vector<double>, kStreams> latencies;
  std::vector<double> odometry_ratios;
  std::vector<double> control_ratios;

  void add(const Latencies& run) {
    std::array<double, kStreams> values{};
    for (std::size_t stream = 0; stream < kStreams; ++stream) {
      values[stream] = percentile(run[stream], fraction);
      latencies[stream].push_back(values[stream]);
    }
    odometry_ratios.push_back(values[kOdometry] / values[kCopy]);
    control_ratios.push_back(values[kControl] / values[kCopy]);
  }
  double ratio() const { return percentile(odometry_ratios, 0.5); }
  double control() const { return percentile(control_ratios, 0.5); }

  Outcome print(const char* name, double limit) const {
    std::printf(
        "  %-16s odometry %6.1f  copy %6.1f  other copy %6.1f us   odometry/copy %.3f (at most %.2f)  "
        "copy/copy %.3f\n",
        name, 1e6 * percentile(latencies[kOdometry], 0.5), 1e6 * percentile(latencies[kCopy], 0.5),
        1e6 * percentile(latencies[kControl], 0.5), ratio(), limit, control());
    if (std::max(control(), 1.0 / control()) > kControlLimit) return Outcome::kInconclusive;
    return ratio() <= limit ? Outcome::kPass : Outcome::kFail;
  }
};

Outcome measure(LatencyProbe& probe, double rate, std::size_t messages, int runs) {
  Comparison median{0.5, {}, {}, {}};
  Comparison tail{0.99, {}, {}, {}};
  std::size_t answered = messages;
  for (int i = 0; i < runs; ++i) {
    const Latencies run = probe.run(rate, messages);
    median.add(run);
    tail.add(run);
    for (const auto& latencies : run) answered = std::min(answered, latencies.size());
  }
  std::printf("%.0f Hz, medians of %d runs of %zu messages, at least %zu answered\n", rate, runs, messages,
              answered);
  const Outcome of_median = median.print("median", kMedianLimit);
  const Outcome of_tail = tail.print("99th percentile", kTailLimit);
  std::fflush(stdout);
  return std::max(of_median, of_tail);
}

void setParameters() {
  const ros::NodeHandle node("/odometry");
  node.setParam("vehicle/wheelbase", 1.2);
  for (const char* axle : {"front", "rear"}) node.setParam(std::string("vehicle/track/") + axle, 1.2);
  for (const char* wheel : {"front_left", "front_right", "rear_left", "rear_right"})
    node.setParam(std::string("encoders/metres_per_tick/") + wheel, 1e-4);
}

/// Loads the nodelets as a manager does.
bool load(nodelet::Loader& loader) {
  return loader.load("/odometry", "bs_car_odometry/OdometryNodelet", {{"/wheel_ticks", "/odometry_in"}},
                     {}) &&
         loader.load("/copy", "copy", {{"/wheel_ticks", "/copy_in"}, {"/copy", "/copy_out"}}, {}) &&
         loader.load("/control", "copy", {{"/wheel_ticks", "/control_in"}, {"/copy", "/control_out"}}, {}) &&
         loader.load("/probe", "probe", {}, {});
}

int run(std::size_t messages, int runs, const std::vector<double>& rates) {
  pluginlib::ClassLoader<nodelet::Nodelet> plugins("nodelet", "nodelet::Nodelet");
  LatencyProbe* probe = nullptr;  // the loader owns it
  const boost::function<boost::shared_ptr<nodelet::Nodelet>(const std::string&)> make =
      [&](const std::string& type) -> boost::shared_ptr<nodelet::Nodelet> {
    if (type == "copy") return boost::make_shared<CopyNodelet>();
    if (type != "probe") return plugins.createInstance(type);
    const auto nodelet = boost::make_shared<LatencyProbe>();
    probe = nodelet.get();
    return nodelet;
  };
  nodelet::Loader loader(make);
  setParameters();
  if (!load(loader) || !probe->waitForConnections()) {
    std::fprintf(stderr, "the nodelets do not run\n");
    return 1;
  }
  probe->run(100.0, 200);  // to warm up
  Outcome worst = Outcome::kPass;
  for (const double rate : rates) worst = std::max(worst, measure(*probe, rate, messages, runs));
  const std::array<const char*, 3> names{"pass", "fail",
                                         "inconclusive: the copies differ, the machine is too busy"};
  std::printf("%s\n", names[static_cast<std::size_t>(worst)]);
  loader.clear();
  return worst == Outcome::kPass ? 0 : 1;
}

}  // namespace
}  // namespace bs_car_odometry::benchmarks

/// live_latency [MESSAGES [RUNS [RATE ...]]]
int main(int argc, char** argv) {
  ros::init(argc, argv, "live_latency");
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const std::size_t messages = arguments.empty() ? 10000 : std::stoul(arguments[0]);
  const int runs = arguments.size() > 1 ? std::stoi(arguments[1]) : 5;
  std::vector<double> rates;
  for (std::size_t i = 2; i < arguments.size(); ++i) rates.push_back(std::stod(arguments[i]));
  if (rates.empty()) rates = {100.0, 1000.0};
  ros::AsyncSpinner spinner(1);
  spinner.start();
  return bs_car_odometry::benchmarks::run(messages, runs, rates);
}
