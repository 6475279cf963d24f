#include "tum_writer.hpp"

#include "bs_car_odometry/ros/conversions.hpp"
#include "tool.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace bs_car_odometry::tools {

namespace {

constexpr std::int64_t kUnits = 1000000000;  // nine decimals
constexpr std::ptrdiff_t kLongestNumber = 32;

/// `units` of 1e-9 with nine decimals: whole numbers are written ten times as fast as printf writes
/// fractions.
char* writeUnits(char* out, std::int64_t units) {
  if (units < 0) *out++ = '-';
  units = std::abs(units);
  out = std::to_chars(out, out + kLongestNumber, units / kUnits).ptr;
  char* const point = out;
  out = std::to_chars(out, out + kLongestNumber, kUnits + units % kUnits).ptr;  // 1ddddddddd
  *point = '.';
  return out;
}

char* writeNumber(char* out, double value) {
  constexpr double kFarthest = 9e9;  // beyond, the units would leave their 64 bits
  if (std::abs(value) < kFarthest) return writeUnits(out, std::llround(value * static_cast<double>(kUnits)));
  return out + std::snprintf(out, kLongestNumber, "%.17g", value);
}

char* writeText(char* out, std::string_view text) { return std::copy(text.begin(), text.end(), out); }

}  // namespace

TumWriter::TumWriter(const std::string& path) : path_(path), file_(path) {
  if (!file_) throw InputError(path + " cannot be written");
}

void TumWriter::write(const OdometryUpdate& update) {
  const geometry_msgs::Quaternion q = toQuaternion(update.estimate.pose.yaw);
  std::array<char, 256> line;
  char* out = writeUnits(line.data(), static_cast<std::int64_t>(toRos(update.stamp).toNSec()));
  out = writeNumber(writeText(out, " "), update.estimate.pose.x);
  out = writeNumber(writeText(out, " "), update.estimate.pose.y);
  out = writeNumber(writeText(out, " 0 0 0 "), q.z);
  out = writeNumber(writeText(out, " "), q.w);
  out = writeText(out, "\n");
  file_.write(line.data(), out - line.data());
}

void TumWriter::close() {
  file_.close();
  if (!file_) throw InputError(path_ + " cannot be written: is the disk full?");
}

}  // namespace bs_car_odometry::tools
