#pragma once

#include "bytes.hpp"

#include <unistd.h>

#include <string>

namespace bs_car_odometry::fuzz {

/// A file for readers that open one by its name; kept in memory.
class MemoryFile {
 public:
  MemoryFile() : path_("/dev/shm/bs_car_odometry_fuzz_" + std::to_string(getpid())) {}
  ~MemoryFile() { std::remove(path_.c_str()); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  void write(const std::string& text) const {
    std::FILE* file = std::fopen(path_.c_str(), "wb");
    require(file != nullptr, "the temporary file can be written");
    std::fwrite(text.data(), 1, text.size(), file);
    std::fclose(file);
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace bs_car_odometry::fuzz
