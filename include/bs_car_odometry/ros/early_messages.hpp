#pragma once

#include <ros/node_handle.h>
#include <ros/wall_timer.h>

#include <functional>
#include <vector>

namespace bs_car_odometry {

/// Messages that are ahead of a clock that goes back (docs/reliability.md, T5). A player that loops sends the
/// first messages of its new run before the clock of it, which comes at a rate of its own; in the old run
/// they would be ages late. They are kept until the clock has gone back, for 0.1 s at most.
class EarlyMessages {
 public:
  using Delivery = std::function<void()>;

  /// @param look  called while something is kept, often enough for the clock
  EarlyMessages(const ros::NodeHandle& node, const std::function<void()>& look);

  /// @return false when too many are kept already, or the last ones were late
  bool keep(const Delivery& delivery);

  /// Notes a message that is neither early nor late.
  void noteTimely() { all_are_late_ = false; }

  /// Delivers everything.
  void deliver();

  /// Delivers everything when the first one has been kept for too long: it is late, not early.
  void deliverLate();

  void stop() { timer_.stop(); }

 private:
  std::vector<Delivery> kept_;
  ros::SteadyTime since_;
  bool all_are_late_{false};
  ros::WallTimer timer_;
};

}  // namespace bs_car_odometry
