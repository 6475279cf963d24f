#include "consistency_table.hpp"

#include "bs_car_odometry/laboratory/chi_square.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <ostream>

namespace bs_car_odometry::tools {

namespace {

using laboratory::Consistency;

std::string text(const char* format, double value) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

/// "68.1 95.0 99.7", in percent.
std::string percentages(const std::array<double, 3>& shares) {
  return text("%.1f", 100.0 * shares[0]) + text(" %.1f", 100.0 * shares[1]) +
         text(" %.1f", 100.0 * shares[2]);
}

/// The truths' shares; with particles also theirs, which need not be those of a Gaussian.
std::string coverage(const std::array<double, 3>& truths, const std::array<double, 3>& expected) {
  const bool particles = std::abs(expected[0] - laboratory::sigmaShares()[0]) > 1e-9;
  return percentages(truths) + (particles ? " (particles " + percentages(expected) + ")" : "");
}

/// Smallest and largest mean NEES while the heading is known well enough; a mark where one is outside.
std::string neesWithinLimit(const laboratory::ConsistencyOverDistance& results) {
  double smallest = std::numeric_limits<double>::infinity();
  double largest = 0.0;
  for (const Consistency& place : results) {
    if (place.sigma().z() >= kHeadingLimit) continue;
    smallest = std::min(smallest, place.meanNees());
    largest = std::max(largest, place.meanNees());
  }
  if (largest == 0.0) return "-";
  const laboratory::Interval interval = laboratory::meanInterval(3.0, results.back().drives());
  const bool inside = interval.holds(smallest) && interval.holds(largest);
  return text("%.2f", smallest) + text(" to %.2f", largest) + (inside ? "" : " OUT");
}

void writeShares(std::ostream& out, const std::array<double, 3>& shares) {
  for (const double share : shares) out << text(",%.5f", share);
}

void writeCsvPlace(std::ostream& out, const Consistency& place) {
  const laboratory::Interval interval = laboratory::meanInterval(3.0, place.drives());
  const Eigen::Vector3d deviation = place.errorCovariance().diagonal().cwiseSqrt();
  out << place.drives() << text(",%.3f", place.distance());
  for (const Eigen::Vector3d& vector : {place.sigma(), deviation, place.meanError()})
    for (Eigen::Index i = 0; i < 3; ++i) out << text(",%.6g", vector(i));
  for (const double value : {place.meanNees(), interval.low, interval.high, place.meanPlainNees(),
                             place.meanTwistNees(), place.twistNeesStandardError()})
    out << text(",%.4f", value);
  writeShares(out, place.regionCoverage());
  writeShares(out, place.plainRegionCoverage());
  writeShares(out, place.expectedRegionCoverage());
  writeShares(out, place.expectedPlainRegionCoverage());
  for (Eigen::Index i = 0; i < 3; ++i) writeShares(out, place.componentCoverage(i));
  out << '\n';
}

/// ",x_1sigma,x_2sigma,x_3sigma"
std::string shareNames(const std::string& name) {
  return ',' + name + "_1sigma," + name + "_2sigma," + name + "_3sigma";
}

}  // namespace

void writeTableHead(std::ostream& out, std::size_t drives) {
  const laboratory::Interval interval = laboratory::meanInterval(3.0, drives);
  out << drives << " drives each. A consistent mean NEES lies between " << text("%.2f", interval.low)
      << " and " << text("%.2f", interval.high)
      << text(" with a probability of %.1f %%", 100.0 * laboratory::kConfidence)
      << ", and 68.3 95.4 99.7 % of the true poses within 1 2 3 sigma.\n\n"
      << "| scenario | wheels | axles | method | heading sigma [rad] | NEES below "
      << text("%.1f", kHeadingLimit)
      << " rad | NEES | in (x, y, yaw) | NEES of twist | within 1 2 3 sigma [%] | in (x, y, yaw) [%] |\n"
      << "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |" << std::endl;
}

void writeTableRow(std::ostream& out, const ConsistencyRow& row) {
  const Consistency& end = row.results.back();
  out << "| " << row.scenario << " | " << row.axle_geometry << " | " << row.axles << " | " << row.method
      << " | " << text("%.3f", end.sigma().z()) << " | " << neesWithinLimit(row.results) << " | "
      << text("%.2f", end.meanNees()) << " | " << text("%.2f", end.meanPlainNees()) << " | "
      << text("%.2f", end.meanTwistNees()) << text(" +/- %.2f", end.twistNeesStandardError()) << " | "
      << coverage(end.regionCoverage(), end.expectedRegionCoverage()) << " | "
      << coverage(end.plainRegionCoverage(), end.expectedPlainRegionCoverage()) << " |" << std::endl;
}

void writeCsvHead(std::ostream& out) {
  out << "scenario,axle_geometry,axles,method,drives,distance,sigma_x,sigma_y,sigma_yaw,deviation_x,"
         "deviation_y,deviation_yaw,mean_error_x,mean_error_y,mean_error_yaw,nees,nees_low,nees_high,"
         "plain_nees,twist_nees,twist_nees_standard_error";
  for (const char* name :
       {"region", "plain_region", "expected_region", "expected_plain_region", "x", "y", "yaw"})
    out << shareNames(name);
  out << '\n';
}

void writeCsvRows(std::ostream& out, const ConsistencyRow& row) {
  for (const Consistency& place : row.results) {
    out << row.scenario << ',' << row.axle_geometry << ',' << row.axles << ',' << row.method << ',';
    writeCsvPlace(out, place);
  }
}

}  // namespace bs_car_odometry::tools
