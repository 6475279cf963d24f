#pragma once

#include "bs_car_odometry/parameters/load.hpp"

#include <boost/program_options.hpp>

#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

/// What the command-line tools have in common: errors, command line, topic names, progress.
namespace bs_car_odometry::tools {

/// Input that is missing, empty or malformed: one line on standard error and exit status 3.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

constexpr int kInputErrorStatus = 3;

/// Input that is in order, but no result came of it: one line on standard error and a status of its own.
class NoResultError : public std::runtime_error {
 public:
  NoResultError(int status, const std::string& what) : std::runtime_error(what), status_(status) {}
  int status() const { return status_; }

 private:
  int status_;
};

/// Runs a tool's body; any exception becomes one line on standard error, "tool: what is wrong".
/// @return the exit status: 0, that of a NoResultError, or 3 for bad input (command line, files, parameters).
int runTool(const std::string& tool, const std::function<void()>& body);

/// "fl, fr, rl", for messages.
std::string listed(const std::vector<std::string>& words);

/// One line on standard error, "warning: text".
void warn(const std::string& text);

/// Parses the command line with Boost.Program_options; `--help` prints `usage` and the options, and ends the
/// process with 0. Arguments of the form `name:=topic` are left to `TopicNames`.
/// @throws InputError
boost::program_options::variables_map parseCommandLine(
    int argc, const char* const* argv, const std::string& usage,
    const boost::program_options::options_description& options,
    const boost::program_options::positional_options_description& positional = {});

/// Topics as named on the command line: `name:=topic` anywhere there renames one, as for any node. A leading
/// slash makes no difference, neither here nor in a bag.
class TopicNames {
 public:
  /// Every topic has its own name.
  TopicNames() = default;

  /// Takes the `name:=topic` arguments; `__name:=...` and the like, which roslaunch adds, are passed over.
  /// @param known the names that the tool uses, such as "wheel_ticks"; other names are refused
  /// @throws InputError
  TopicNames(int argc, const char* const* argv, const std::vector<std::string>& known);

  /// The topic that `name` stands for, with a leading slash.
  std::string topic(const std::string& name) const;

  /// True when `recorded`, a topic of a bag with or without a leading slash, is the one `name` stands for.
  bool matches(const std::string& recorded, const std::string& name) const;

  /// The topic that `name` stands for as it may stand in a bag: with and without the leading slash, for
  /// `rosbag::TopicQuery`.
  std::vector<std::string> spellings(const std::string& name) const;

 private:
  std::map<std::string, std::string> topics_;  ///< renamed ones, both sides with a leading slash
};

/// Parameters of the vehicle file `configs[0]`, with the values of further files on top and the `settings`
/// ("odometry/axles=rear") last; warnings go to standard error.
/// @throws InputError for a setting that is not key=value, ParameterError for the rest
Parameters loadVehicle(const std::vector<std::string>& configs, const std::vector<std::string>& settings);

/// The same with `calibration_file` applied, where one is named.
/// @throws CalibrationFileError when that cannot be used: offline somebody waits for the result
Parameters loadCalibratedVehicle(const std::vector<std::string>& configs,
                                 const std::vector<std::string>& settings);

/// The same without the calibration, for tools that make one: a warning says so where a file is named.
Parameters loadNominalVehicle(const std::vector<std::string>& configs,
                              const std::vector<std::string>& settings);

/// Without the calibration, and with the warnings left to the caller.
LoadedParameters readVehicle(const std::vector<std::string>& configs,
                             const std::vector<std::string>& settings);

/// A progress line on standard error, only when that is a terminal; cheap to call for every message.
class Progress {
 public:
  Progress(std::string label, double total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void update(double done);

  /// Clears the line, for what else is written; the next update brings it back.
  void hide();

 private:
  std::string label_;
  double total_;
  int percent_shown_{-1};
  bool is_terminal_;
};

}  // namespace bs_car_odometry::tools
