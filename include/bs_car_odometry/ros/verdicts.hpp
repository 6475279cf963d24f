#pragma once

#include "bs_car_odometry/core/odometry_pipeline.hpp"

#include <string>

namespace bs_car_odometry {

/// One sentence on why a message was turned down, with the remedy; empty for kAccepted.
const char* explain(Verdict verdict);

/// The same with what is known of the newest such message.
std::string explain(Verdict verdict, const InputCounts& counts);

/// True for what is an ERROR, not a WARN.
bool isError(Verdict verdict);

/// One sentence on counters that may have wrapped unseen, and on a covariance that was repaired (E6, O2).
const char* explainAmbiguousGap();
const char* explainRepair();

/// One sentence on a state, with the remedy; empty when nominal.
const char* explain(OdometryState state);

}  // namespace bs_car_odometry
