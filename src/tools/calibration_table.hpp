#pragma once

#include "calibration_findings.hpp"

#include <string>

namespace bs_car_odometry::tools {

/// What was read: a line for each bag, and how well the laser poses fit.
std::string dataTable(const FilteredBags& filtered);

/// Every estimated parameter with its standard deviation, prior, and whether it was observed; with a
/// refinement, what the filter alone has found too, and the noise.
std::string parameterTable(const Findings& findings);

/// Drift of every bag at its end: before, after, and with the gains that the other bags give.
std::string driftTable(const Findings& findings);

}  // namespace bs_car_odometry::tools
