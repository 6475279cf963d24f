#pragma once

#include "bs_car_odometry/calibration/atomic_file.hpp"
#include "bs_car_odometry/calibration/result.hpp"

#include <cstdint>
#include <string>

namespace bs_car_odometry::calibration {

/// A calibration file that is not used, with all that it says; what is wrong and what to do about it, in one
/// sentence.
class CalibrationFileError : public FileError {
 public:
  using FileError::FileError;
};

/// Larger files are no calibrations.
constexpr std::size_t kLargestFile = 65536;

/// What gains belong to, as one line of a calibration file: "vehicle: {name: ..., ...}", without line break.
std::string vehicleLine(const Parameters& parameters);

/// CRC-32 of that line, by which a car is recognised in messages.
std::uint32_t vehicleChecksum(const Parameters& parameters);

/// A calibration as the text of a file (docs/interface.md, calibration file). Every number reads back as the
/// same number.
/// @param parameters  those of the calibration: vehicle, method and axles
/// @throws CalibrationFileError when nothing is listed, or a value or covariance could not be read back
std::string toText(const CalibrationResult& result, const Parameters& parameters);

/// The inverse. Checks format, checksum, car, names, ranges and covariance; any mismatch refuses everything.
/// Safe with whatever bytes.
/// @param parameters  those of the car that is to use it
/// @throws CalibrationFileError
CalibrationResult fromText(const std::string& text, const Parameters& parameters);

/// Writes a calibration to the disk: afterwards the file is the new one, or the one before.
/// @throws FileError when it cannot be written, CalibrationFileError as toText()
void writeCalibrationFile(const std::string& path, const CalibrationResult& result,
                          const Parameters& parameters);

/// @throws CalibrationFileError, with the file's name
CalibrationResult readCalibrationFile(const std::string& path, const Parameters& parameters);

/// Why a value cannot be used; empty when it can. The ranges are those of the parameters' own.
std::string faultOf(std::size_t parameter, double value);

/// Finite, of a size that makes sense, symmetric and positive semidefinite but for rounding. Zero rows are
/// parameters that are not there.
bool isCovariance(const ParameterMatrix& matrix);

/// Puts the listed values in the place of those that a vehicle file gives, and their covariance in the place
/// of their block of p(A): the other parameters keep `noise/systematic`, independent of the listed ones. The
/// covariances of scales, mount and time offset have no place there.
void applyCalibration(const CalibrationResult& result, Parameters& parameters);

/// The same for a covariance over the systematic parameters.
void replaceBlock(const CalibrationResult& result, SystematicCovariance& covariance);

/// Reads and applies `calibration_file`, if one is named.
/// @return why it is not used, in which case the parameters are as they were; empty if it is
/// @throws CalibrationFileError for the same reason where `require_calibration` is set, and when it names
/// none
std::string applyCalibrationFile(Parameters& parameters);

}  // namespace bs_car_odometry::calibration
