#pragma once

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

  /// What is wrong, with the remedy; empty when nothing is.
  const char* finding() const { return finding_; }

 private:
  void run();
  bool stopsWithin(double seconds);

  std::atomic<const char*> finding_{""};
  std::mutex mutex_;
  std::condition_variable stopping_;
  bool stopped_{false};
  std::thread thread_;
};

}  // namespace bs_car_odometry
