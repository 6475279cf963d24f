#pragma once

#include "bs_car_odometry/parameters/parameters.hpp"

#include <yaml-cpp/yaml.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace bs_car_odometry {

/// Thrown with one message that lists every missing, mistyped and out-of-range value: name, value, what is
/// allowed, one a line.
class ParameterError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct LoadedParameters {
  Parameters parameters;
  std::vector<std::string> warnings;  ///< unknown names, each with the nearest known one
};

/// Reads parameters from a YAML tree (a file's, or the parameter server's).
/// Numbers may be strings when they are wholly numeric and finite, such as `1e-3`.
/// @throws ParameterError
LoadedParameters loadParameters(const YAML::Node& tree);

/// The tree of a YAML file, with the values of further files (a result of fit_noise, for instance) on top in
/// their order and `overrides` ("odometry/axles", "rear") last.
/// @param paths  at least one
/// @throws ParameterError when a file cannot be read or parsed, or a further file or an override names an
///         unknown parameter.
YAML::Node loadParameterFiles(const std::vector<std::string>& paths,
                              const std::vector<std::pair<std::string, std::string>>& overrides = {});

/// Paths of every known parameter, with slashes, in the order of the documentation.
std::vector<std::string> parameterPaths();

/// The words out of which a parameter ("odometry/axles") takes one; none for any other kind of parameter.
/// @throws ParameterError when there is no such parameter
std::vector<std::string> parameterWords(const std::string& path);

/// The word that such a parameter has in `parameters`.
std::string parameterWord(Parameters parameters, const std::string& path);

}  // namespace bs_car_odometry
