#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace bs_car_odometry::tools {

/// Reads items in a thread of its own while those before are worked on, in order and at most two batches at a
/// time: one that is filled, and one that is worked on. What the reader uses must not be touched elsewhere as
/// long as this lives.
template <typename Item>
class ReadAhead {
 public:
  /// Fills an item, which may hold one from before; false when there is none any more. May throw.
  using Read = std::function<bool(Item&)>;

  explicit ReadAhead(Read read) : read_(std::move(read)), reader_([this] { fillBatches(); }) {}

  /// Stops the reader, at the latest after one batch.
  ~ReadAhead() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopped_ = true;
    }
    changed_.notify_all();
    reader_.join();
  }

  ReadAhead(const ReadAhead&) = delete;
  ReadAhead& operator=(const ReadAhead&) = delete;

  /// The next item, valid until the next call; nullptr at the end.
  /// @throws what the reader has thrown, after all items before it
  const Item* next() {
    while (true) {
      const Batch& batch = batches_[taken_];
      if (!is_mine_) waitUntil([&batch] { return batch.full; });
      is_mine_ = true;
      if (position_ < batch.size) return &batch.items[position_++];
      if (batch.error) std::rethrow_exception(batch.error);
      if (batch.last) return nullptr;
      giveBack();
    }
  }

  /// Long enough for the threads to meet rarely, short enough for a processor's cache.
  static constexpr std::size_t kBatchSize = 256;

 private:
  /// Belongs to the reader until it is full, then to the caller; `full` alone is shared, under the mutex.
  struct Batch {
    std::vector<Item> items = std::vector<Item>(kBatchSize);
    std::size_t size{0};
    bool last{false};
    std::exception_ptr error;
    bool full{false};
  };

  void fillBatches() {
    for (std::size_t i = 0;; i = 1 - i) {
      Batch& batch = batches_[i];
      if (!waitUntil([&batch] { return !batch.full; })) return;
      fill(batch);
      const bool over = batch.last;
      setFull(batch, true);
      if (over) return;
    }
  }

  void fill(Batch& batch) {
    batch.size = 0;
    try {
      while (batch.size < kBatchSize && !batch.last) {
        if (read_(batch.items[batch.size]))
          ++batch.size;
        else
          batch.last = true;
      }
    } catch (...) {
      batch.error = std::current_exception();
      batch.last = true;
    }
  }

  void giveBack() {
    setFull(batches_[taken_], false);
    taken_ = 1 - taken_;
    position_ = 0;
    is_mine_ = false;
  }

  /// @return false when all is to stop
  template <typename Condition>
  bool waitUntil(Condition condition) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [&] { return stopped_ || condition(); });
    return !stopped_;
  }

  void setFull(Batch& batch, bool full) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      batch.full = full;
    }
    changed_.notify_all();
  }

  Read read_;
  std::array<Batch, 2> batches_;
  std::size_t taken_{0};     ///< the batch that is worked on
  std::size_t position_{0};  ///< in it
  bool is_mine_{false};      ///< it is full, and the caller knows
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopped_{false};
  std::thread reader_;  // the last member: it uses all others
};

}  // namespace bs_car_odometry::tools
