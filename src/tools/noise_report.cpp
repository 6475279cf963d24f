#include "noise_report.hpp"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <iomanip>
#include <sstream>

namespace bs_car_odometry::tools {

namespace {

constexpr int kNoiseDigits = 4;
constexpr int kGainDigits = 8;

const std::string kSystematic = "noise/systematic/";

std::string number(double value, int digits) {
  std::ostringstream text;
  text << std::setprecision(digits) << value;
  return text.str();
}

std::string plusMinus(double value, double std, int digits) {
  return number(value, digits) + " +/- " + number(std, 2);
}

std::string summary(const NoiseFit& fit) {
  return std::to_string(fit.runs) + (fit.runs == 1 ? " run in " : " runs in ") +
         std::to_string(fit.recordings) + (fit.recordings == 1 ? " recording, " : " recordings, ") +
         number(fit.distance, 4) + " m, " + std::to_string(fit.places) + " places; log-likelihood " +
         number(fit.log_likelihood, 8);
}

std::string nameOf(const FoundGains& gains) { return gains.wheels.empty() ? "gains" : gains.wheels; }

void insert(const std::string& path, const std::string& value, YAML::Node tree) {
  const std::size_t slash = path.find('/');
  if (slash == std::string::npos) {
    tree[path] = value;
    return;
  }
  const std::string key = path.substr(0, slash);
  if (!tree[key]) tree[key] = YAML::Node(YAML::NodeType::Map);
  insert(path.substr(slash + 1), value, tree[key]);
}

YAML::Node valuesOf(const NoiseFit& fit) {
  YAML::Node tree(YAML::NodeType::Map);
  for (const FoundNoise& noise : fit.noise)
    if (noise.name.rfind(kSystematic, 0) != 0) insert(noise.name, number(noise.value, kNoiseDigits), tree);
  for (const auto& [name, std] : fit.next_drive) insert(name, number(std, kNoiseDigits), tree);
  if (fit.gains.size() > 1) return tree;
  for (std::size_t j = 0; j < fit.gain_names.size(); ++j)
    insert(fit.gain_names[j], number(fit.gains.front().value[static_cast<Eigen::Index>(j)], kGainDigits),
           tree);
  return tree;
}

std::string asComments(const std::string& text) {
  std::istringstream lines(text);
  std::string comments;
  for (std::string line; std::getline(lines, line);) comments += (line.empty() ? "#" : "# " + line) + "\n";
  return comments;
}

void addGains(const NoiseFit& fit, const FoundGains& gains, std::ostream& text) {
  text << nameOf(gains) << ":\n";
  for (std::size_t j = 0; j < fit.gain_names.size(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    text << "  " << fit.gain_names[j] << ": "
         << plusMinus(gains.value[i], std::sqrt(gains.covariance(i, i)), 6) << ", in another drive +/- "
         << number(gains.std_in_next_drive[i], 2) << "\n";
  }
  text << "  covariance: [";
  for (Eigen::Index i = 0; i < gains.covariance.rows(); ++i)
    for (Eigen::Index j = 0; j < gains.covariance.cols(); ++j)
      text << (i + j > 0 ? ", " : "") << number(gains.covariance(i, j), kNoiseDigits);
  text << "]\n";
}

}  // namespace

std::string noiseTable(const NoiseFit& fit) {
  std::ostringstream text;
  text << summary(fit) << "\n";
  for (const FoundNoise& noise : fit.noise) {
    const bool spread = noise.name.rfind(kSystematic, 0) == 0;
    text << noise.name << (spread ? ", from recording to recording: " : ": ")
         << (noise.value > 0.0 ? plusMinus(noise.value, noise.std, kNoiseDigits)
                               : "0, nothing seen beyond the other errors")
         << "\n";
  }
  for (const FoundGains& gains : fit.gains) addGains(fit, gains, text);
  return text.str();
}

std::string noiseYaml(const NoiseFit& fit) {
  YAML::Emitter values;
  values << valuesOf(fit);
  return "# Found by fit_noise; to be loaded on top of the vehicle's file. noise/systematic is for another "
         "drive:\n"
         "# independent errors of the gains that do what the covariance below and the differences between\n"
         "# recordings would do to the ends of these drives.\n#\n" +
         asComments(noiseTable(fit)) + values.c_str() + "\n";
}

}  // namespace bs_car_odometry::tools
