#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace bs_car_odometry::testing {

/// A program that runs beside the test; what it writes is kept. Ended at the end of its scope.
class ChildProcess {
 public:
  /// @param command  path of the program and its arguments
  explicit ChildProcess(const std::vector<std::string>& command);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// True once the output holds the text.
  bool waitForOutput(const std::string& text, double seconds = 20.0);

  /// Reads what has been written so far: a process that writes waits once the pipe is full.
  void readWritten();

  /// Exit status; none when it did not end by itself in time, or by a signal.
  std::optional<int> waitForExit(double seconds = 20.0);

  /// As Ctrl-C does.
  void interrupt();

  /// As kill -9 does; the process has ended afterwards.
  void kill();

  /// As kill -STOP does, and kill -CONT.
  void suspend();
  void resume();

  pid_t id() const { return process_; }
  const std::string& output() const { return output_; }

 private:
  static constexpr int kPollPeriod = 20;  // ms

  bool readOutput(int patience = kPollPeriod);

  pid_t process_{-1};
  int pipe_{-1};
  bool ended_{false};
  int status_{0};
  std::string output_;
};

}  // namespace bs_car_odometry::testing
