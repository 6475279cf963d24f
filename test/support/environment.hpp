#pragma once

#include <cstdlib>
#include <string>

namespace bs_car_odometry {

/// A number that scripts which test for longer set in the environment.
inline double fromEnvironment(const char* name, double otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::stod(text);
}

}  // namespace bs_car_odometry
