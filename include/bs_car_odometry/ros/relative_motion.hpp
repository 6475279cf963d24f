#pragma once

#include "bs_car_odometry/RelativeMotion.h"
#include "bs_car_odometry/core/motion_history.hpp"

namespace bs_car_odometry {

/// Answers the service `~relative_motion` from a history; a refusal says what the history spans.
/// @param unmeasured_variance  of z [m^2], roll and pitch [rad^2]
void fillRelativeMotion(const MotionHistory& history, double unmeasured_variance,
                        const RelativeMotion::Request& request, RelativeMotion::Response& response);

}  // namespace bs_car_odometry
