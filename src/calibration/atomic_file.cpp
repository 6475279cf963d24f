#include "bs_car_odometry/calibration/atomic_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace bs_car_odometry::calibration {

namespace {

/// A path that leads elsewhere could have anything overwritten.
constexpr const char* kSymbolicLink = "it is a symbolic link; name the file itself";

std::string folderOf(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

std::string fileNameOf(const std::string& path) { return path.substr(path.rfind('/') + 1); }

/// One name, so that what a crash leaves does not pile up.
std::string hiddenPath(const std::string& path) { return folderOf(path) + "/." + fileNameOf(path) + ".tmp"; }

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw FileError(path + " cannot be written: " + why);
}

[[noreturn]] void failBySystem(const std::string& path, int error = errno) {
  const std::string why = std::strerror(error);
  if (error == ENOSPC || error == EDQUOT) fail(path, why + "; make room on the disk");
  if (error == ENOENT || error == ENOTDIR) fail(path, why + "; make its folder, or name another one");
  fail(path, why + "; choose a folder in which this user may write");
}

/// An open file that is closed at the end of its scope.
class Descriptor {
 public:
  explicit Descriptor(int file) : file_(file) {}
  ~Descriptor() {
    if (file_ >= 0) ::close(file_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return file_; }

 private:
  int file_;
};

void checkTarget(const std::string& path) {
  const std::string name = fileNameOf(path);
  if (name.empty() || name == "." || name == "..") fail(path, "it is not the name of a file; name one");
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return;  // not there yet, or its folder is not
  if (S_ISLNK(status.st_mode)) fail(path, kSymbolicLink);
  if (!S_ISREG(status.st_mode)) fail(path, "it is not a regular file; name another one");
}

bool isSameFile(int file, const std::string& path) {
  struct stat opened {};
  struct stat named {};
  return ::fstat(file, &opened) == 0 && ::lstat(path.c_str(), &named) == 0 && S_ISREG(opened.st_mode) &&
         opened.st_nlink == 1 && opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

/// Opens and locks the hidden file: two programs that save at the same time must not write into one.
int openHidden(const std::string& path) {
  const std::string hidden = hiddenPath(path);
  const int file = ::open(hidden.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
  if (file < 0) failBySystem(path);
  // Another writer may have renamed it since it was opened.
  if (::flock(file, LOCK_EX | LOCK_NB) == 0 && isSameFile(file, hidden)) return file;
  ::close(file);
  fail(path, "another program is writing it, or " + hidden + " is in the way; remove that");
}

void writeAll(int file, const std::string& text, const std::string& path) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t written = ::write(file, text.data() + done, text.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) failBySystem(path);
    done += static_cast<std::size_t>(written);
  }
}

/// Until a folder's entries are on the disk, a renaming may be undone by a loss of power.
void syncFolder(const std::string& path) {
  const Descriptor folder(::open(folderOf(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.get() < 0) failBySystem(path);
  // Some file systems cannot do this (EINVAL); the file itself is safe by then.
  if (::fsync(folder.get()) != 0 && errno != EINVAL) failBySystem(path);
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)), temporary_path_(hiddenPath(path_)) {
  checkTarget(path_);
  file_ = openHidden(path_);
  if (::ftruncate(file_, 0) == 0) return;
  const int error = errno;
  remove();
  failBySystem(path_, error);
}

AtomicFile::~AtomicFile() { remove(); }

void AtomicFile::remove() {
  if (file_ < 0) return;
  ::unlink(temporary_path_.c_str());
  close();
}

/// Gives up the lock.
void AtomicFile::close() {
  ::close(file_);
  file_ = -1;
}

void AtomicFile::write(const std::string& text) { writeAll(file_, text, path_); }

void AtomicFile::commit() {
  if (::fsync(file_) != 0 || ::rename(temporary_path_.c_str(), path_.c_str()) != 0) failBySystem(path_);
  close();
  syncFolder(path_);
}

void writeAtomically(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

void checkWritable(const std::string& path) { const AtomicFile file(path); }

std::string readSmallFile(const std::string& path, std::size_t most) {
  const auto refuse = [&path](const std::string& why) -> void {
    throw FileError(path + " cannot be read: " + why);
  };
  // Without O_NONBLOCK a named pipe would hold up who opens it.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (file.get() < 0)
    refuse(errno == ELOOP ? kSymbolicLink : std::string(std::strerror(errno)) + "; check its name");
  struct stat status {};
  if (::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode))
    refuse("it is not a regular file; check its name");
  std::string text(most + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t got = ::read(file.get(), &text[size], text.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) refuse(std::string(std::strerror(errno)) + "; check the disk");
    if (got <= 0) break;
    size += static_cast<std::size_t>(got);
  }
  if (size > most) refuse("it is larger than " + std::to_string(most / 1024) + " kB; check its name");
  text.resize(size);
  return text;
}

}  // namespace bs_car_odometry::calibration
