#include "tool.hpp"

#include "bs_car_odometry/calibration/result_file.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <iterator>
#include <utility>

namespace bs_car_odometry::tools {
namespace {

namespace po = boost::program_options;

/// The text in one line: line breaks become "; ".
std::string oneLine(const std::string& text) {
  std::string line;
  for (const char c : text) {
    if (c == '\n') {
      line += "; ";
    } else {
      line += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return line;
}

int reportError(const std::string& tool, const std::string& what) {
  std::cerr << tool << ": " << oneLine(what) << std::endl;
  return kInputErrorStatus;
}

std::string withLeadingSlash(const std::string& name) {
  return !name.empty() && name.front() == '/' ? name : '/' + name;
}

const std::string kRemap = ":=";

bool isRemapping(const std::string& argument) { return argument.find(kRemap) != std::string::npos; }

bool isAmong(const std::vector<std::string>& names, const std::string& name_with_slash) {
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& name) { return withLeadingSlash(name) == name_with_slash; });
}

std::pair<std::string, std::string> splitSetting(const std::string& setting) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0)
    throw InputError("--set " + setting +
                     ": expected a parameter path, '=' and a value, such as "
                     "--set odometry/axles=rear");
  return {setting.substr(0, equals), setting.substr(equals + 1)};
}

}  // namespace

int runTool(const std::string& tool, const std::function<void()>& body) {
  try {
    body();
    return 0;
  } catch (const NoResultError& error) {
    reportError(tool, error.what());
    return error.status();
  } catch (const std::exception& error) {
    return reportError(tool, error.what());
  } catch (...) {
    return reportError(tool, "unknown error");
  }
}

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

void warn(const std::string& text) { std::cerr << "warning: " << oneLine(text) << std::endl; }

po::variables_map parseCommandLine(int argc, const char* const* argv, const std::string& usage,
                                   const po::options_description& options,
                                   const po::positional_options_description& positional) {
  std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc);
  arguments.erase(std::remove_if(arguments.begin(), arguments.end(), isRemapping), arguments.end());
  po::options_description all = options;
  all.add_options()("help,h", "print this text and exit");
  po::variables_map values;
  try {
    // Guessing is off: an option that a later version adds must not change what a script's short form means.
    po::store(po::command_line_parser(arguments)
                  .options(all)
                  .positional(positional)
                  .style(po::command_line_style::unix_style & ~po::command_line_style::allow_guessing)
                  .run(),
              values);
    if (values.count("help") > 0) {
      std::cout << usage << "\n\n" << all << std::flush;
      std::exit(EXIT_SUCCESS);
    }
    po::notify(values);
  } catch (const po::error& error) {
    throw InputError(std::string(error.what()) + " (see --help)");
  }
  return values;
}

TopicNames::TopicNames(int argc, const char* const* argv, const std::vector<std::string>& known) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (!isRemapping(argument) || argument.compare(0, 2, "__") == 0) continue;
    const std::size_t separator = argument.find(kRemap);
    const std::string name = withLeadingSlash(argument.substr(0, separator));
    const std::string topic = withLeadingSlash(argument.substr(separator + kRemap.size()));
    if (topic == "/") throw InputError(argument + ": the topic is missing");
    if (!isAmong(known, name))
      throw InputError(argument + ": no topic of that name; known: " + listed(known));
    if (!topics_.emplace(name, topic).second) throw InputError(argument + ": the topic is renamed twice");
  }
}

std::string TopicNames::topic(const std::string& name) const {
  const auto renamed = topics_.find(withLeadingSlash(name));
  return renamed != topics_.end() ? renamed->second : withLeadingSlash(name);
}

bool TopicNames::matches(const std::string& recorded, const std::string& name) const {
  return withLeadingSlash(recorded) == topic(name);
}

std::vector<std::string> TopicNames::spellings(const std::string& name) const {
  const std::string full = topic(name);
  return {full, full.substr(1)};
}

LoadedParameters readVehicle(const std::vector<std::string>& configs,
                             const std::vector<std::string>& settings) {
  std::vector<std::pair<std::string, std::string>> overrides;
  std::transform(settings.begin(), settings.end(), std::back_inserter(overrides), splitSetting);
  return loadParameters(loadParameterFiles(configs, overrides));
}

Parameters loadVehicle(const std::vector<std::string>& configs, const std::vector<std::string>& settings) {
  const LoadedParameters loaded = readVehicle(configs, settings);
  const std::string place = configs.front() + ": ";
  for (const std::string& warning : loaded.warnings) warn(place + warning);
  return loaded.parameters;
}

Parameters loadNominalVehicle(const std::vector<std::string>& configs,
                              const std::vector<std::string>& settings) {
  Parameters parameters = loadVehicle(configs, settings);
  if (!parameters.calibration_file.empty())
    warn("calibration_file is not used: a calibration begins with the gains of the vehicle file (" +
         configs.front() + ")");
  return parameters;
}

Parameters loadCalibratedVehicle(const std::vector<std::string>& configs,
                                 const std::vector<std::string>& settings) {
  Parameters parameters = loadVehicle(configs, settings);
  const std::string error = calibration::applyCalibrationFile(parameters);
  if (!error.empty()) throw calibration::CalibrationFileError(error);
  return parameters;
}

Progress::Progress(std::string label, double total)
    : label_(std::move(label)), total_(total), is_terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (percent_shown_ >= 0) std::cerr << std::endl;
}

void Progress::update(double done) {
  if (!is_terminal_ || !(total_ > 0.0)) return;
  const int percent = static_cast<int>(100.0 * std::clamp(done / total_, 0.0, 1.0));
  if (percent == percent_shown_) return;
  percent_shown_ = percent;
  std::cerr << '\r' << label_ << ' ' << percent << " %" << std::flush;
}

void Progress::hide() {
  if (percent_shown_ < 0) return;
  percent_shown_ = -1;
  std::cerr << "\r\033[K" << std::flush;
}

}  // namespace bs_car_odometry::tools
