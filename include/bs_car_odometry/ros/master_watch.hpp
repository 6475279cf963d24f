#pragma once

#include "bs_car_odometry/ros/log_throttle.hpp"

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace bs_car_odometry {

/// Looks now and then whether the master still knows this process (docs/reliability.md, N5), in a thread of
/// its own: a master may take its time, and data flow without it.
class MasterWatch {
 public:
  MasterWatch();
  ~MasterWatch();
  MasterWatch(const MasterWatch&) = delete;
  MasterWatch& operator=(const MasterWatch&) = delete;

  /// Says what is wrong, with the remedy, once in a while; nothing when nothing is.
  void warn();
  /// Adds the same to a status.
  void addTo(diagnostic_updater::DiagnosticStatusWrapper& status) const;

 private:
  void run();
  bool stopsWithin(double seconds);

  std::atomic<const char*> finding_{nullptr};
  LogThrottle log_;
  std::mutex mutex_;
  std::condition_variable stopping_;
  bool stopped_{false};
  std::thread thread_;
};

}  // namespace bs_car_odometry
