#pragma once

#include "bs_car_odometry/parameters/parameters.hpp"

#include "entry.hpp"
#include "report.hpp"

namespace bs_car_odometry::schema {

/// Every parameter, one entry each; the entries refer to `parameters`, which must outlive them.
Schema parameterSchema(Parameters& parameters);

/// Tidies frame names: a leading slash, which tf2 refuses, goes with a warning.
void stripLeadingSlashes(Parameters& parameters, Report& report);

/// What parameters must satisfy together. A rule is passed over while one of its parameters is wrong by
/// itself.
void checkRules(const Parameters& parameters, Report& report);

}  // namespace bs_car_odometry::schema
