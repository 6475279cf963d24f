#pragma once

#include "bs_car_odometry/laboratory/drive.hpp"

#include <cstdint>
#include <limits>
#include <vector>

namespace bs_car_odometry::drives {

using laboratory::Sample;

constexpr double kForever = std::numeric_limits<double>::infinity();

/// From `from` to `until` [s] the wheel's counter counts `factor` times as much: 0 stands still, -1 runs
/// backwards, 1.2 belongs to a wheel that slips.
void scaleTravel(std::vector<Sample>& drive, Wheel wheel, double factor, double from = 0.0,
                 double until = kForever);

/// The wheel's counter goes on with the speed of that time: its sensor is silent, and the driver repeats
/// itself.
void freezeSpeed(std::vector<Sample>& drive, Wheel wheel, double from);

void swapCounters(std::vector<Sample>& drive, Wheel a, Wheel b);

/// The sensor gives its reading of that time from then on.
void freezeAngle(std::vector<Sample>& drive, Axle axle, double from = 0.0);

void offsetAngle(std::vector<Sample>& drive, Axle axle, double offset, double from = 0.0);

/// Each reading of a counter is off by 10,000 to 1,000,000 ticks with this probability.
void addSpikes(std::vector<Sample>& drive, double probability, std::uint64_t seed);

}  // namespace bs_car_odometry::drives
