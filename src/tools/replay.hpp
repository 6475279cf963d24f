#pragma once

#include "bs_car_odometry/parameters/parameters.hpp"
#include "tool.hpp"

#include <string>

namespace bs_car_odometry::tools {

/// What a replay reads and writes; an empty name leaves an output out.
struct ReplayFiles {
  std::string input;
  std::string output;  ///< bag with odom, odometry_status and /tf
  std::string tum;     ///< t x y z qx qy qz qw, a pose per line
};

/// Runs the odometry over a bag as fast as the machine allows, through the class that the nodelet drives; the
/// clock is the bag's record time.
/// @throws InputError when a topic is missing or of another type, or no message gave a pose
void replay(const Parameters& parameters, const TopicNames& topics, const ReplayFiles& files);

}  // namespace bs_car_odometry::tools
