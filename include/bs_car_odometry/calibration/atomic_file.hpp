#pragma once

#include <stdexcept>
#include <string>

namespace bs_car_odometry::calibration {

/// A file that cannot be read or written; what is wrong and what to do about it, in one sentence.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A file that is whole or does not change at all: written beside it under a hidden name, brought to the
/// disk, then renamed. Neither a crash nor a full disk leaves half a file or harms the one that was there. A
/// crash leaves the hidden file, which the next writing takes over; two programs that write one file at the
/// same time do not mix, since the second one is refused.
class AtomicFile {
 public:
  /// @throws FileError when the folder is missing or not writable, or the path leads to something else
  explicit AtomicFile(std::string path);
  ~AtomicFile();  ///< removes what was not committed
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Where to write, for those who open it themselves; the file exists and is empty.
  const std::string& temporaryPath() const { return temporary_path_; }
  void write(const std::string& text);  ///< @throws FileError

  /// Puts the file in its place, after the writer has closed it. @throws FileError
  void commit();

 private:
  void remove();
  void close();

  std::string path_;
  std::string temporary_path_;
  int file_{-1};  ///< the hidden file, locked; none once committed
};

/// Makes such a file of a text. @throws FileError
void writeAtomically(const std::string& path, const std::string& text);

/// Finds out whether a file could be written, by making and removing the hidden one. @throws FileError
void checkWritable(const std::string& path);

/// The text of a regular file.
/// @throws FileError, also for a symbolic link and for a file of more than `most` bytes
std::string readSmallFile(const std::string& path, std::size_t most);

}  // namespace bs_car_odometry::calibration
