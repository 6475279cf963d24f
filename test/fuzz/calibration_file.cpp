// Any text as a calibration file or, after the first byte, a checkpoint; with the checksum that it should
// have, which no random search would find.

#include "calibration/calibration_file.hpp"
#include "bytes.hpp"
#include "memory_file.hpp"

#include "bs_car_odometry/calibration/checkpoint.hpp"

namespace bs_car_odometry::fuzz {
namespace {

using calibration::testing::withChecksum;

Parameters parameters() { return calibration::testing::cycab(); }

/// What is accepted can be used, and written again.
void readResult(const std::string& text) {
  try {
    Parameters car = parameters();
    const calibration::CalibrationResult result = calibration::fromText(text, car);
    require(calibration::isCovariance(result.covariance), "the covariance is one");
    calibration::applyCalibration(result, car);
    calibration::fromText(calibration::toText(result, parameters()), parameters());
  } catch (const calibration::CalibrationFileError& error) {
    require(*error.what() != '\0', "it says why");
  }
}

void readCheckpoint(const std::string& text) {
  constexpr double kNow = 1600000000.0;  // s
  static MemoryFile file;
  file.write(text);
  try {
    const auto memory = calibration::readCheckpoint(file.path(), parameters(), kNow);
    require(!memory || memory->values.allFinite(), "the values are finite");
  } catch (const calibration::FileError& error) {
    require(*error.what() != '\0', "it says why");
  }
}

}  // namespace
}  // namespace bs_car_odometry::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace bs_car_odometry::fuzz;
  if (size == 0) return 0;
  const std::string text = textOf(data + 1, size - 1);
  switch (data[0] % 4) {
    case 0:
      readResult(text);
      break;
    case 1:
      readResult(withChecksum(text));
      break;
    case 2:
      readCheckpoint(text);
      break;
    default:
      readCheckpoint(withChecksum(text));
  }
  return 0;
}
