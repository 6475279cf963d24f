#pragma once

#include <stdexcept>
#include <string>

namespace bs_car_odometry::calibration {

/// A file that cannot be read or written; what is wrong and what to do about it, in one sentence.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Makes a file that is whole or does not change at all: written beside it under a hidden name, brought to
/// the disk, then renamed. A crash leaves the hidden file, which the next writing takes over.
/// @throws FileError; a file that was there is as it was
void writeAtomically(const std::string& path, const std::string& text);

/// Finds out whether a file could be written, by making and removing the hidden one.
/// @throws FileError
void checkWritable(const std::string& path);

/// The text of a regular file.
/// @throws FileError, also for a symbolic link and for a file of more than `most` bytes
std::string readSmallFile(const std::string& path, std::size_t most);

}  // namespace bs_car_odometry::calibration
