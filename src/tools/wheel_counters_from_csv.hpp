#pragma once

#include "csv_recording.hpp"
#include "csv_table.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// The counter of one wheel at every row of the table: ticks as they are, increments summed, speeds
/// integrated over time. All but `ticks` begin at 0.
/// @throws InputError for ticks that are not whole and counters beyond 2^53
std::vector<std::int64_t> countersFromCsv(const CsvTable& table, const std::string& column,
                                          const CsvSource& source);

}  // namespace bs_car_odometry::tools
