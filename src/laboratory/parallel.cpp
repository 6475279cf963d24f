#include "bs_car_odometry/laboratory/parallel.hpp"

#include <algorithm>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace bs_car_odometry::laboratory {

namespace {

/// What the threads share: which task is next, what went wrong.
class Queue {
 public:
  Queue(std::size_t count, const std::function<void(std::size_t)>& finished)
      : count_(count), finished_(finished) {}

  void work(const std::function<void(std::size_t)>& task) {
    for (std::size_t i = next(); i < count_; i = next()) {
      try {
        task(i);
        finish();
      } catch (...) {
        fail(std::current_exception());
      }
    }
  }

  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::size_t next() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return error_ || next_ == count_ ? count_ : next_++;
  }

  void finish() {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++done_;
    if (finished_) finished_(done_);
  }

  void fail(const std::exception_ptr& error) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!error_) error_ = error;
  }

  std::size_t count_;
  const std::function<void(std::size_t)>& finished_;
  std::mutex mutex_;
  std::size_t next_{0};
  std::size_t done_{0};
  std::exception_ptr error_;
};

}  // namespace

void runInParallel(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& task,
                   const std::function<void(std::size_t)>& finished) {
  const std::size_t wanted = threads > 0 ? threads : std::max(1U, std::thread::hardware_concurrency());
  Queue queue(count, finished);
  std::vector<std::thread> workers;
  try {
    for (std::size_t i = 1; i < std::min(wanted, count); ++i) workers.emplace_back([&] { queue.work(task); });
  } catch (const std::system_error&) {  // no more threads to be had: those there are will do
  }
  queue.work(task);
  for (std::thread& worker : workers) worker.join();
  queue.rethrow();
}

}  // namespace bs_car_odometry::laboratory
