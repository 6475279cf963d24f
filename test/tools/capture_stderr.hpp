#pragma once

#include <gtest/gtest.h>

#include <iostream>

namespace bs_car_odometry::tools::testing {

/// GoogleTest's, on a stream that is whole: one write that failed before, into a pipe that was full, would
/// leave std::cerr silent for good.
inline void captureStderr() {
  std::cerr.clear();
  ::testing::internal::CaptureStderr();
}

}  // namespace bs_car_odometry::tools::testing
