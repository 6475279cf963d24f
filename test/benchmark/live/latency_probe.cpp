#include "latency_probe.hpp"

#include <algorithm>
#include <thread>

namespace bs_car_odometry::benchmarks {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kQueue = 200;
constexpr std::int64_t kTicksPerMessage = 10;

}  // namespace

void LatencyProbe::onInit() {
  ros::NodeHandle& node = getNodeHandle();
  const std::array<const char*, kStreams> inputs{"odometry_in", "copy_in", "control_in"};
  for (std::size_t stream = 0; stream < kStreams; ++stream)
    publishers_[stream] = node.advertise<WheelTicks>(inputs[stream], kQueue);
  steering_publisher_ = node.advertise<SteeringAngle>("front_steering", kQueue);
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  subscribers_ = {node.subscribe("odom", kQueue, &LatencyProbe::onOdometry, this, hints),
                  node.subscribe("copy_out", kQueue, &LatencyProbe::onCopy, this, hints),
                  node.subscribe("control_out", kQueue, &LatencyProbe::onControl, this, hints)};
}

bool LatencyProbe::waitForConnections() const {
  const auto connected = [this] {
    return steering_publisher_.getNumSubscribers() > 0 &&
           std::all_of(publishers_.begin(), publishers_.end(),
                       [](auto& p) { return p.getNumSubscribers() > 0; }) &&
           std::all_of(subscribers_.begin(), subscribers_.end(),
                       [](auto& s) { return s.getNumPublishers() > 0; });
  };
  for (int i = 0; i < 100 && !connected(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  return connected();
}

Latencies LatencyProbe::run(double rate, std::size_t messages) {
  latencies_ = Latencies();
  const auto period =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(1.0 / rate));
  const SteadyTime start = Clock::now() + std::chrono::milliseconds(100);
  std::array<Stream, kStreams> order{kOdometry, kCopy, kControl};
  for (std::size_t i = 0; i < messages; ++i) {
    for (std::size_t slot = 0; slot < kStreams; ++slot)
      publish(order[slot], i, start + (kStreams * i + slot) * period / kStreams, period);
    std::next_permutation(order.begin(), order.end());
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const std::lock_guard<std::mutex> lock(mutex_);
  return latencies_;
}

void LatencyProbe::publish(Stream stream, std::size_t number, SteadyTime slot,
                           std::chrono::nanoseconds period) {
  const auto ticks = boost::make_shared<WheelTicks>();
  const auto count = static_cast<std::int64_t>(number) * kTicksPerMessage;
  ticks->front_left = ticks->front_right = ticks->rear_left = ticks->rear_right = count;
  std::this_thread::sleep_until(slot - period / (2 * kStreams));
  ticks->header.stamp = ros::Time::now();
  if (stream == kOdometry) publishSteering(ticks->header.stamp);
  std::this_thread::sleep_until(slot);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    sent_[stream][ticks->header.stamp] = Clock::now();
  }
  publishers_[stream].publish(ticks);
}

void LatencyProbe::publishSteering(const ros::Time& stamp) {
  const auto angle = boost::make_shared<SteeringAngle>();
  angle->header.stamp = stamp;
  angle->angle = 0.0;  // all wheels count the same: no sensor contradicts another
  steering_publisher_.publish(angle);
}

void LatencyProbe::note(Stream stream, const ros::Time& stamp) {
  const SteadyTime now = Clock::now();
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto sent = sent_[stream].find(stamp);
  if (sent == sent_[stream].end()) return;
  latencies_[stream].push_back(std::chrono::duration<double>(now - sent->second).count());
  sent_[stream].erase(sent);
}

}  // namespace bs_car_odometry::benchmarks
