#include "bs_car_odometry/laboratory/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <stdexcept>
#include <vector>

namespace bs_car_odometry::laboratory {
namespace {

TEST(RunInParallel, everyTaskRunsOnceAndIsReported) {
  for (const unsigned threads : {0U, 1U, 3U, 8U}) {
    std::vector<std::atomic<int>> runs(100);
    std::vector<std::size_t> reports;
    runInParallel(
        runs.size(), threads, [&](std::size_t i) { ++runs[i]; },
        [&](std::size_t done) { reports.push_back(done); });
    for (const std::atomic<int>& count : runs) EXPECT_EQ(count, 1);
    ASSERT_EQ(reports.size(), runs.size());
    for (std::size_t i = 0; i < reports.size(); ++i) EXPECT_EQ(reports[i], i + 1);
  }
}

TEST(RunInParallel, withoutTasksItReturns) {
  runInParallel(0, 2, [](std::size_t) { FAIL(); });
}

TEST(RunInParallel, whatATaskThrowsReachesTheCaller) {
  std::atomic<int> begun{0};
  const auto task = [&](std::size_t i) {
    ++begun;
    if (i == 3) throw std::runtime_error("the fourth");
  };
  EXPECT_THROW(runInParallel(100000, 2, task), std::runtime_error);
  EXPECT_LT(begun, 100000) << "tasks after the error are left out";
}

}  // namespace
}  // namespace bs_car_odometry::laboratory
