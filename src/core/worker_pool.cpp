#include "bs_car_odometry/core/worker_pool.hpp"

namespace bs_car_odometry {

WorkerPool::WorkerPool(std::size_t threads) {
  try {
    for (std::size_t k = 1; k < threads; ++k) workers_.emplace_back([this, k] { work(k); });
  } catch (...) {  // no more threads to be had: those that run must end before they are destroyed
    stop();
    throw;
  }
}

WorkerPool::~WorkerPool() { stop(); }

void WorkerPool::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  begin_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void WorkerPool::start(Call call, const void* job) {
  if (workers_.empty()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    call_ = call;
    job_ = job;
    running_ = workers_.size();
    ++generation_;
  }
  begin_.notify_all();
}

void WorkerPool::finish() {
  if (workers_.empty()) return;
  std::unique_lock<std::mutex> lock(mutex_);
  end_.wait(lock, [this] { return running_ == 0; });
}

void WorkerPool::work(std::size_t k) {
  std::size_t done = 0;
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    begin_.wait(lock, [&] { return stop_ || generation_ != done; });
    if (stop_) return;
    done = generation_;
    const Call call = call_;
    const void* job = job_;
    lock.unlock();
    call(job, k);
    lock.lock();
    if (--running_ == 0) end_.notify_one();
  }
}

}  // namespace bs_car_odometry
