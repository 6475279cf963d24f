#include "child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>

namespace bs_car_odometry::testing {

namespace {

using SteadyClock = std::chrono::steady_clock;

SteadyClock::time_point deadlineIn(double seconds) {
  return SteadyClock::now() + std::chrono::milliseconds(static_cast<long>(seconds * 1e3));
}

[[noreturn]] void become(const std::vector<std::string>& command, int output) {
  ::dup2(output, STDOUT_FILENO);
  ::dup2(output, STDERR_FILENO);
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  ::execvp(arguments.front(), arguments.data());
  ::_exit(127);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) std::abort();
  process_ = ::fork();
  if (process_ == 0) become(command, ends[1]);
  ::close(ends[1]);
  pipe_ = ends[0];
}

ChildProcess::~ChildProcess() {
  if (!ended_) {
    interrupt();
    waitForExit(5.0);
  }
  if (!ended_) {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, &status_, 0);
  }
  ::close(pipe_);
}

/// False when nothing came within the patience [ms].
bool ChildProcess::readOutput(int patience) {
  pollfd waiting{pipe_, POLLIN, 0};
  if (::poll(&waiting, 1, patience) <= 0) return false;
  std::array<char, 4096> text{};
  const ssize_t length = ::read(pipe_, text.data(), text.size());
  if (length > 0) output_.append(text.data(), static_cast<std::size_t>(length));
  return length > 0;
}

void ChildProcess::readWritten() {
  while (readOutput(0)) {
  }
}

bool ChildProcess::waitForOutput(const std::string& text, double seconds) {
  for (const auto deadline = deadlineIn(seconds); SteadyClock::now() < deadline;) {
    if (output_.find(text) != std::string::npos) return true;
    readOutput();
  }
  return false;
}

std::optional<int> ChildProcess::waitForExit(double seconds) {
  for (const auto deadline = deadlineIn(seconds); !ended_ && SteadyClock::now() < deadline;) {
    readOutput();
    ended_ = ::waitpid(process_, &status_, WNOHANG) == process_;
  }
  if (!ended_) return std::nullopt;
  readOutput();
  if (!WIFEXITED(status_)) return std::nullopt;
  return WEXITSTATUS(status_);
}

void ChildProcess::kill() {
  ::kill(process_, SIGKILL);
  ended_ = ::waitpid(process_, &status_, 0) == process_;
}

void ChildProcess::interrupt() { ::kill(process_, SIGINT); }

void ChildProcess::suspend() { ::kill(process_, SIGSTOP); }

void ChildProcess::resume() { ::kill(process_, SIGCONT); }

}  // namespace bs_car_odometry::testing
