#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace bs_car_odometry::tools::testing {

/// A folder of its own, removed with all it holds at the end of its scope.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    path_ = std::filesystem::temp_directory_path() / "bs_car_odometry_test.XXXXXX";
    if (::mkdtemp(path_.data()) == nullptr) std::abort();
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string file(const std::string& name) const { return path_ + "/" + name; }

  /// Writes a file and returns its path.
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(file(name), std::ios::binary) << text;
    return file(name);
  }

  std::size_t files() const {
    std::size_t files = 0;
    for (auto entry = std::filesystem::directory_iterator(path_); entry != std::filesystem::end(entry);
         ++entry)
      ++files;
    return files;
  }

 private:
  std::string path_;
};

/// The message of the InputError, or other exception, that the call ends with; empty when it returns.
template <typename Call>
std::string errorOf(const Call& call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

}  // namespace bs_car_odometry::tools::testing
