// Items that are read by another thread while those before are worked on.

#include "../../src/tools/read_ahead.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <vector>

namespace bs_car_odometry::tools::testing {
namespace {

constexpr std::size_t kBatch = ReadAhead<std::size_t>::kBatchSize;

/// Gives 0, 1, 2, ...; after `count` of them, the end.
ReadAhead<std::size_t>::Read countTo(std::size_t count) {
  return [next = std::size_t{0}, count](std::size_t& item) mutable {
    item = next++;
    return item < count;
  };
}

std::vector<std::size_t> allOf(ReadAhead<std::size_t>& ahead) {
  std::vector<std::size_t> items;
  while (const std::size_t* item = ahead.next()) items.push_back(*item);
  return items;
}

TEST(ReadAhead, givesAllItemsInTheirOrder) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, kBatch - 1, kBatch, kBatch + 1, 2 * kBatch,
                                  2 * kBatch + 1, 100 * kBatch + 7}) {
    ReadAhead<std::size_t> ahead(countTo(count));
    std::vector<std::size_t> expected(count);
    std::iota(expected.begin(), expected.end(), std::size_t{0});
    EXPECT_EQ(allOf(ahead), expected) << count;
    EXPECT_EQ(ahead.next(), nullptr) << "the end stays the end";
  }
}

TEST(ReadAhead, readsTheNextBatchWhileTheFirstIsWorkedOn) {
  std::promise<void> second_batch;
  ReadAhead<std::size_t> ahead([&, count = std::size_t{0}](std::size_t& /*item*/) mutable {
    if (++count == 2 * kBatch) second_batch.set_value();
    return true;
  });
  ASSERT_NE(ahead.next(), nullptr);
  // Long enough for any machine: the wait ends at once when the batch has been read.
  EXPECT_EQ(second_batch.get_future().wait_for(std::chrono::seconds(60)), std::future_status::ready);
}

TEST(ReadAhead, isNeverMoreThanTwoBatchesAhead) {
  constexpr std::size_t kCount = 50 * kBatch;
  std::atomic<std::size_t> taken{0};
  std::atomic<std::size_t> most_ahead{0};
  ReadAhead<std::size_t> ahead([&, next = std::size_t{0}](std::size_t& item) mutable {
    item = next++;
    if (item < kCount) most_ahead = std::max(most_ahead.load(), next - taken);
    return item < kCount;
  });
  while (ahead.next() != nullptr) ++taken;
  EXPECT_EQ(taken, kCount);
  EXPECT_LE(most_ahead, 2 * kBatch);
}

TEST(ReadAhead, keepsTheItemsForTheReaderToFillAgain) {
  std::atomic<std::size_t> made_anew{0};
  ReadAhead<std::optional<std::size_t>> ahead(
      [&, next = std::size_t{0}](std::optional<std::size_t>& item) mutable {
        if (!item) ++made_anew;
        item = next++;
        return *item < 10 * kBatch;
      });
  while (ahead.next() != nullptr) {
  }
  EXPECT_EQ(made_anew, 2 * kBatch);
}

TEST(ReadAhead, throwsWhatTheReaderThrewAfterTheItemsBefore) {
  for (const std::size_t good : {std::size_t{0}, std::size_t{3}, kBatch, 2 * kBatch + 5}) {
    ReadAhead<std::size_t> ahead([good, next = std::size_t{0}](std::size_t& item) mutable {
      if (next == good) throw std::out_of_range("damaged");
      item = next++;
      return true;
    });
    std::size_t taken = 0;
    const auto take = [&] {
      while (const std::size_t* item = ahead.next()) EXPECT_EQ(*item, taken++);
    };
    EXPECT_THROW(take(), std::out_of_range);
    EXPECT_EQ(taken, good);
    EXPECT_THROW(ahead.next(), std::out_of_range) << "and again";
  }
}

TEST(ReadAhead, endsTheReaderWhenTheCallerStopsEarly) {
  for (const std::size_t taken : {std::size_t{0}, std::size_t{1}, kBatch, kBatch + 1}) {
    const auto read = std::make_shared<std::size_t>(0);
    {
      ReadAhead<std::size_t> ahead([read](std::size_t& /*item*/) { return ++*read > 0; });  // no end
      for (std::size_t i = 0; i < taken; ++i) ASSERT_NE(ahead.next(), nullptr);
    }
    EXPECT_EQ(read.use_count(), 1) << "the reader is gone";
    EXPECT_LE(*read, taken + 2 * kBatch);
  }
}

TEST(ReadAhead, endsTheReaderWhenTheCallerThrows) {
  std::size_t read = 0;
  const auto work = [&read] {
    ReadAhead<std::size_t> ahead([&read](std::size_t& /*item*/) { return ++read > 0; });
    ahead.next();
    throw std::runtime_error("work");
  };
  EXPECT_THROW(work(), std::runtime_error);
  EXPECT_LE(read, 2 * kBatch);
}

TEST(ReadAhead, isOverWithoutBeingAsked) {
  for (int i = 0; i < 1000; ++i) ReadAhead<std::size_t> ahead(countTo(5));  // ends before, amid, after
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
