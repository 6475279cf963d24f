#pragma once

#include "bs_car_odometry/laboratory/consistency.hpp"

#include <iosfwd>
#include <string>

namespace bs_car_odometry::tools {

/// One odometry over one scenario.
struct ConsistencyRow {
  std::string scenario;
  std::string axle_geometry;
  std::string axles;
  std::string method;
  laboratory::ConsistencyOverDistance results;
};

/// Beyond this standard deviation of the heading [rad] no matrix describes the poses any more, whatever its
/// coordinates (docs/model.md, 5.7): rows are judged up to there.
constexpr double kHeadingLimit = 0.2;

/// The table as Markdown: its head, then line by line.
void writeTableHead(std::ostream& out, std::size_t drives);
void writeTableRow(std::ostream& out, const ConsistencyRow& row);

/// The same with every place along the drive, as CSV.
void writeCsvHead(std::ostream& out);
void writeCsvRows(std::ostream& out, const ConsistencyRow& row);

}  // namespace bs_car_odometry::tools
