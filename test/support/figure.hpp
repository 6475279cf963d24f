#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace bs_car_odometry {

/// What a test has measured, for the table of results in docs/reliability.md; written as std::printf() does,
/// which it does as well. One for each test; where a test has parameters, numbers that differ become their
/// range.
[[gnu::format(printf, 1, 2)]] inline void recordFigure(const char* format, ...) {
  std::array<char, 256> text{};
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  std::printf("%s\n", text.data());
  ::testing::Test::RecordProperty("figure", text.data());
}

/// The next 1, 2 or 5 times a power of ten, so that what differs from run to run reads the same; 0 for 0 and
/// less.
inline double roundedUp(double value) {
  if (!(value > 0.0)) return 0.0;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 5.0})
    if (value <= step * power * (1.0 + 1e-12)) return step * power;
  return 10.0 * power;
}

}  // namespace bs_car_odometry
