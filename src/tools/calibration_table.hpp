#pragma once

#include "calibration_bags.hpp"
#include "dead_reckoning.hpp"

#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// Dead reckoning over one bag with the configured and with the found values.
struct BagPaths {
  std::vector<ReckonedPose> before;
  std::vector<ReckonedPose> after;
};

/// What was read: a line for each bag, and how well the laser poses fit.
std::string dataTable(const FilteredBags& filtered);

/// Every estimated parameter with its standard deviation, prior, and whether it was observed.
std::string parameterTable(const FilteredBags& filtered);

/// Drift of every bag at its end, before and after.
std::string driftTable(const FilteredBags& filtered, const std::vector<BagPaths>& paths);

}  // namespace bs_car_odometry::tools
