#pragma once

#include "../../src/tools/noise_fit.hpp"
#include "bs_car_odometry/ros/simulated_drive.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace bs_car_odometry::tools::testing {

/// The papers' Cycab, fine ticks, with the odometry of these axles.
Parameters cycab(AxleSelection axles);

/// A drive of the simulated car with its exact truth (`ground_truth`) or with laser poses.
RecordedDrive simulate(const Parameters& parameters, const SimulatedDriveSettings& settings,
                       bool laser = false);

/// `count` drives with seeds from `first_seed` on, each a recording of its own.
std::vector<RecordedRun> simulatedRuns(const Parameters& parameters, SimulatedDriveSettings settings,
                                       std::uint64_t first_seed, std::size_t count);

}  // namespace bs_car_odometry::tools::testing
