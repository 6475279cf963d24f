#pragma once

#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/simulation/true_motion.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry::bench {

/// The Cycab of the papers, 0.1 mm a tick, at most 5 m/s, initially not at the origin.
OdometryConfiguration cycab();

/// Seconds since the start of the test as a stamp.
Time at(double seconds);

/// The same counter on every wheel.
PerWheel<std::int64_t> all(std::int64_t ticks);

/// A pipeline, with the fewest words for one message. Receipts are those of the stamps unless said otherwise.
struct Bench {
  explicit Bench(const OdometryConfiguration& configuration = cycab()) : pipeline(configuration) {}

  Verdict steer(double stamp, double angle) { return steer(stamp, angle, stamp); }
  Verdict steer(double stamp, double angle, double receipt);
  Verdict wheels(double stamp, const PerWheel<std::int64_t>& ticks) { return wheels(stamp, ticks, stamp); }
  Verdict wheels(double stamp, const PerWheel<std::int64_t>& ticks, double receipt);
  std::optional<OdometryUpdate> next(double now) { return pipeline.next(at(now)); }

  /// Steering straight ahead, wheels, and what comes of them.
  std::optional<OdometryUpdate> step(double stamp, const PerWheel<std::int64_t>& ticks, double angle = 0.0);

  OdometryPipeline pipeline;
};

/// One received message: of the wheels, or of the front steering.
struct Message {
  double receipt{0.0};  ///< [s]
  double stamp{0.0};    ///< [s]
  std::optional<PerWheel<std::int64_t>> ticks;
  double angle{0.0};  ///< [rad], without ticks

  bool isWheels() const { return ticks.has_value(); }
};

/// Where the simulated car truly is when its wheels are read.
struct Truth {
  double stamp{0.0};
  simulation::Pose pose;
};

struct Drive {
  std::vector<Message> messages;  ///< in the order of their receipt
  std::vector<Truth> truth;       ///< one for each wheel message
  double length{0.0};             ///< [m]
};

/// The simulated slalom, exact but for rounding; wheels are received 1 ms after their stamp, angles 2 ms.
Drive slalom(const OdometryConfiguration& configuration, double duration, double wheel_rate,
             double steering_rate);

/// Runs messages through a pipeline as a node does; what still waits at the end gives up its wait.
std::vector<OdometryUpdate> run(OdometryPipeline& pipeline, const std::vector<Message>& messages);
std::vector<OdometryUpdate> run(const OdometryConfiguration& configuration,
                                const std::vector<Message>& messages);

/// True when every bit of both estimates is the same.
bool identical(const OdometryEstimate& a, const OdometryEstimate& b);
bool identical(const std::vector<OdometryUpdate>& a, const std::vector<OdometryUpdate>& b);

/// Largest distance between odometry and truth as a part of the whole length; the updates' stamps select the
/// truth.
double largestDeparture(const std::vector<OdometryUpdate>& updates, const Drive& drive);

bool isFinite(const OdometryUpdate& update);

}  // namespace bs_car_odometry::bench
