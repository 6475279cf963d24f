#pragma once

namespace bs_car_odometry::tools {

/// The tool `calibrate_bag`.
/// @throws InputError and ParameterError (status 3); NoResultError with kNotObservedStatus or
///         kNotConvergedStatus
void calibrate(int argc, const char* const* argv);

constexpr int kNotObservedStatus = 2;
constexpr int kNotConvergedStatus = 4;

}  // namespace bs_car_odometry::tools
