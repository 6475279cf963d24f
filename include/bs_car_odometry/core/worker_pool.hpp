#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <thread>
#include <vector>

namespace bs_car_odometry {

/// Threads that wait for work. The caller of run() is the first of them; with one thread there are no others.
class WorkerPool {
 public:
  explicit WorkerPool(std::size_t threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  std::size_t threads() const { return workers_.size() + 1; }

  /// Calls job(k) for every k below threads(), each on a thread of its own, and returns when all have ended.
  /// Allocates nothing. The job must not throw.
  template <typename Job>
  void run(const Job& job) {
    start([](const void* context, std::size_t k) { (*static_cast<const Job*>(context))(k); }, &job);
    job(0);
    finish();
  }

 private:
  using Call = void (*)(const void* job, std::size_t k);

  void stop();
  void start(Call call, const void* job);
  void finish();
  void work(std::size_t k);

  std::mutex mutex_;
  std::condition_variable begin_;
  std::condition_variable end_;
  Call call_{nullptr};
  const void* job_{nullptr};
  std::size_t generation_{0};  ///< of the work
  std::size_t running_{0};
  bool stop_{false};
  std::vector<std::thread> workers_;
};

}  // namespace bs_car_odometry
