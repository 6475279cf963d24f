#pragma once

#include "bs_car_odometry/core/odometry_pipeline.hpp"

#include <string>

namespace bs_car_odometry {

/// One sentence on why a message was turned down, with the remedy; empty for kAccepted.
const char* explain(Verdict verdict);

/// The same with what is known of the newest such message.
std::string explain(Verdict verdict, const InputCounts& counts);

/// One sentence on a state, with the remedy; empty when nominal.
const char* explain(OdometryState state);

}  // namespace bs_car_odometry
