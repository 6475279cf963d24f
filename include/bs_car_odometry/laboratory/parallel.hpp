#pragma once

#include <cstddef>
#include <functional>

namespace bs_car_odometry::laboratory {

/// Calls task(i) once for every i below `count`, on several threads; returns when all are done.
/// @param threads   0: one for each processor
/// @param finished  told after each task how many are done, one call at a time, on any thread; may be empty
/// @throws what a task throws first; tasks not yet begun are then left out
void runInParallel(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& task,
                   const std::function<void(std::size_t)>& finished = {});

}  // namespace bs_car_odometry::laboratory
