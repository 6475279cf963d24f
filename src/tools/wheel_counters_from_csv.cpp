#include "wheel_counters_from_csv.hpp"

#include "tool.hpp"

#include <cmath>

namespace bs_car_odometry::tools {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kLargestExact = 9007199254740992.0;  // 2^53: beyond it a double skips whole numbers

/// Speed of the tyre's contact point for one unit of the reading [m/s].
double metresPerSecond(const CsvSource& source) {
  switch (source.wheel_unit) {
    case WheelUnit::kRpm:
      return 2.0 * kPi / 60.0 * source.wheel_radius;
    case WheelUnit::kRadiansPerSecond:
      return source.wheel_radius;
    default:
      return 1.0;
  }
}

void checkWhole(const CsvTable& table, const std::string& column, std::size_t row) {
  const double ticks = table[column][row];
  if (ticks != std::floor(ticks))
    throw InputError(table.place(row) + ": " + std::to_string(ticks) + " in the column '" + column +
                     "' is not a whole number of ticks");
}

std::int64_t toCounter(double ticks, const CsvTable& table, std::size_t row) {
  if (!(std::abs(ticks) < kLargestExact))
    throw InputError(table.place(row) +
                     ": the counter leaves its range; the unit or --metres-per-tick is wrong");
  return std::llround(ticks);
}

std::vector<double> summedIncrements(const std::vector<double>& increments) {
  // The first row's increment belongs to an interval before the recording.
  std::vector<double> sums{0.0};
  for (std::size_t i = 1; i < increments.size(); ++i) sums.push_back(sums.back() + increments[i]);
  return sums;
}

/// Integral of the speed, by the trapezoid. Whether a reading shows the speed since the reading before it, at
/// its stamp or until the next one, the source does not say; holding it one way or the other shifts the
/// wheels by half an interval against the steering and the poses, in opposite directions. The trapezoid lies
/// between the two, and on recordings of real cars (nuScenes, comma2k19) so did its error; the end points of
/// the three differ by less than 0.4 % of the distance.
std::vector<double> integrated(const std::vector<double>& times, const std::vector<double>& speeds,
                               double scale) {
  std::vector<double> sums{0.0};
  for (std::size_t i = 1; i < speeds.size(); ++i)
    sums.push_back(sums.back() + 0.5 * (speeds[i - 1] + speeds[i]) * scale * (times[i] - times[i - 1]));
  return sums;
}

std::vector<double> unroundedTicks(const CsvTable& table, const std::string& column,
                                   const CsvSource& source) {
  switch (source.wheel_unit) {
    case WheelUnit::kTicks:
      return table[column];
    case WheelUnit::kTickIncrements:
      return summedIncrements(table[column]);
    default:
      return integrated(table["t"], table[column], metresPerSecond(source) / source.metres_per_tick);
  }
}

}  // namespace

std::vector<std::int64_t> countersFromCsv(const CsvTable& table, const std::string& column,
                                          const CsvSource& source) {
  const bool are_ticks =
      source.wheel_unit == WheelUnit::kTicks || source.wheel_unit == WheelUnit::kTickIncrements;
  const std::vector<double> ticks = unroundedTicks(table, column, source);
  std::vector<std::int64_t> counters;
  for (std::size_t row = 0; row < ticks.size(); ++row) {
    if (are_ticks) checkWhole(table, column, row);
    // Each is rounded from the running sum, so that rounding errors do not add up.
    counters.push_back(toCounter(ticks[row], table, row));
  }
  return counters;
}

}  // namespace bs_car_odometry::tools
