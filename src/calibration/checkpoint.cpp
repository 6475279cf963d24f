#include "bs_car_odometry/calibration/checkpoint.hpp"

#include "bs_car_odometry/calibration/atomic_file.hpp"
#include "bs_car_odometry/calibration/result_file.hpp"
#include "result_text.hpp"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <locale>
#include <sstream>

namespace bs_car_odometry::calibration {

namespace {

constexpr const char* kFirstLine = "bs_car_odometry checkpoint 1";
constexpr double kClockError = 60.0;  // [s], by which a checkpoint may seem to come from the future

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw FileError(path + " is not used: " + what);
}

/// Everything that a filter's state means something with only while it stays the same.
std::uint32_t configurationChecksum(const Parameters& parameters) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(std::numeric_limits<double>::max_digits10);
  text << vehicleLine(parameters) << ' ' << static_cast<int>(parameters.calibration.method) << ' '
       << static_cast<int>(parameters.odometry.axles) << ' ' << priorDeviations(parameters).transpose() << ' '
       << valuesOf(parameters).transpose();
  const std::string line = text.str();
  return crc32(line.data(), line.size());
}

/// The values of a checkpoint in the order of the file, for writing and for reading.
template <typename Archive, typename Memory>
void values(Archive& archive, Memory& memory) {
  for (Eigen::Index i = 0; i < memory.values.size(); ++i) archive(memory.values[i]);
  for (Eigen::Index i = 0; i < memory.covariance.size(); ++i) archive(memory.covariance.data()[i]);
  auto& driven = memory.driven;
  for (auto* value : {&driven.distance, &driven.straight, &driven.turned_left, &driven.turned_right,
                      &driven.speed_change, &driven.turn_rate_change})
    archive(*value);
  auto& counts = memory.counts;
  for (auto* count : {&counts.used, &counts.rejected, &counts.relocalisations, &counts.dropped})
    archive(*count);
}

std::int64_t nanoseconds(Time time) { return time.time_since_epoch().count(); }

/// The text without its checksum; empty when that does not match.
std::string withoutChecksum(const std::string& text) {
  const std::size_t begin = text.rfind(kChecksumKey);
  if (begin == std::string::npos || text.substr(begin) != checksumLine(text.data(), begin)) return {};
  return text.substr(0, begin);
}

/// Reads the head of a checkpoint, which says whether it may be used.
void checkHead(const std::string& path, std::istringstream& stream, const Parameters& parameters,
               double now) {
  std::string first;
  double written = 0.0;
  std::uint32_t configuration = 0;
  std::getline(stream, first);
  stream >> written >> configuration;
  if (!stream || first != kFirstLine) refuse(path, "it was cut or altered");
  if (configuration != configurationChecksum(parameters))
    refuse(path, "it is of another car, or of other parameters");
  if (!(now - written < kOldestCheckpoint)) refuse(path, "it is older than an hour");
  if (now - written < -kClockError) refuse(path, "it is from the future: was the clock set back?");
}

}  // namespace

std::string checkpointPath(const std::string& output) { return output + ".checkpoint"; }

void writeCheckpoint(const std::string& path, const CalibrationMemory& memory, const Parameters& parameters,
                     double now) {
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  stream.precision(std::numeric_limits<double>::max_digits10);
  stream << kFirstLine << '\n' << now << ' ' << configurationChecksum(parameters) << '\n';
  stream << nanoseconds(memory.span.begin) << ' ' << nanoseconds(memory.span.end) << '\n';
  const auto write = [&stream](auto value) { stream << value << '\n'; };
  values(write, memory);
  const std::string text = stream.str();
  writeAtomically(path, text + checksumLine(text.data(), text.size()));
}

std::optional<CalibrationMemory> readCheckpoint(const std::string& path, const Parameters& parameters,
                                                double now) {
  if (std::FILE* file = std::fopen(path.c_str(), "r")) {
    std::fclose(file);
  } else {
    return std::nullopt;
  }
  std::istringstream stream(withoutChecksum(readSmallFile(path, kLargestFile)));
  stream.imbue(std::locale::classic());
  checkHead(path, stream, parameters, now);
  CalibrationMemory memory;
  std::int64_t begin = 0;
  std::int64_t end = 0;
  stream >> begin >> end;
  memory.span = {timeFromNanoseconds(begin), timeFromNanoseconds(end)};
  const auto read = [&stream](auto& value) { stream >> value; };
  values(read, memory);
  if (!stream || !memory.values.allFinite() || !isCovariance(memory.covariance))
    refuse(path, "it was cut or altered");
  return memory;
}

void removeCheckpoint(const std::string& path) { std::remove(path.c_str()); }

}  // namespace bs_car_odometry::calibration
