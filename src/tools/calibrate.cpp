#include "calibrate.hpp"

#include "calibrate_options.hpp"
#include "calibration_bags.hpp"
#include "calibration_table.hpp"

#include "bs_car_odometry/calibration/observability.hpp"
#include "bs_car_odometry/calibration/result.hpp"
#include "bs_car_odometry/ros/conversions.hpp"

#include <cmath>
#include <fstream>
#include <iostream>

namespace bs_car_odometry::tools {

using namespace calibration;

namespace {

/// Estimated, but not observed.
ParameterMask missingOf(const FilteredBags& filtered) {
  ParameterMask missing{};
  for (std::size_t i = 0; i < kCount; ++i) missing[i] = filtered.estimated[i] && !filtered.observed[i];
  return missing;
}

calibration::Knowledge knowledgeOf(const FilteredBags& filtered) {
  return {filtered.estimated, filtered.prior,
          filtered.estimate.covariance.diagonal().cwiseMax(0.0).cwiseSqrt(), filtered.excitation};
}

std::string namesOf(const ParameterMask& mask, bool gains_only) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kCount; ++i)
    if (mask[i] && (isGain(i) || !gains_only)) names.push_back(parameterName(i));
  return listed(names);
}

/// @throws InputError where a gain tells of a wrong vehicle file
void requirePlausible(const FilteredBags& filtered) {
  const std::string implausible = implausibleGains(filtered.estimate.values, filtered.observed);
  if (!implausible.empty()) throw InputError(implausible + "; nothing was written");
}

/// @throws NoResultError where gains that are to be saved were not observed
void requireObserved(const FilteredBags& filtered) {
  const ParameterMask missing = missingOf(filtered);
  const std::string gains = namesOf(missing, true);
  const bool partial = filtered.parameters.calibration.allow_partial;
  if (gains.empty() || (partial && !namesOf(filtered.observed, true).empty())) return;
  throw NoResultError(
      kNotObservedStatus,
      "not observed: " + gains + "; " + calibration::missing(knowledgeOf(filtered)) +
          (partial ? "; nothing was written"
                   : "; nothing was written (calibration/allow_partial=true saves the rest)"));
}

std::vector<std::string> fileNames(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (const std::string& path : paths) names.push_back(path.substr(path.rfind('/') + 1));
  return names;
}

CalibrationResult resultOf(const FilteredBags& filtered, const CalibrateOptions& options) {
  CalibrationResult result;
  result.values = filtered.estimate.values;
  result.covariance = filtered.estimate.covariance;
  result.listed = filtered.observed;
  result.not_observed = missingOf(filtered);
  result.data.bags = fileNames(options.bags);
  result.data.from = toRos(filtered.span.begin).toSec();
  result.data.to = toRos(filtered.span.end).toSec();
  result.data.distance = filtered.excitation.distance;
  result.data.laser_poses = filtered.counts.used;
  result.data.rejected = filtered.counts.rejected;
  return result;
}

void save(const CalibrationResult& result, const std::string& path) {
  AtomicOutput output(path);
  std::ofstream file(output.temporaryPath());
  file.precision(17);
  for (std::size_t i = 0; i < kCount; ++i)
    if (result.listed[i])
      file << parameterName(i) << ": " << result.values[static_cast<Eigen::Index>(i)] << '\n';
  file.close();
  output.commit();
}

std::vector<BagPaths> pathsOf(const FilteredBags& filtered) {
  std::vector<BagPaths> paths;
  const ParameterVector configured = valuesOf(filtered.parameters);
  for (const CalibratedBag& bag : filtered.bags)
    paths.push_back({deadReckon(bag.drive, filtered.parameters, configured, bag.good),
                     deadReckon(bag.drive, filtered.parameters, filtered.estimate.values, bag.good)});
  return paths;
}

}  // namespace

void calibrate(int argc, const char* const* argv) {
  const CalibrateOptions options = calibrateOptions(argc, argv);
  static_cast<void>(AtomicOutput(options.output));  // rather now than after an hour's bag
  const FilteredBags filtered = filterBags(options, {});
  std::cout << dataTable(filtered) << '\n' << parameterTable(filtered) << std::flush;
  requirePlausible(filtered);
  const std::vector<BagPaths> paths = pathsOf(filtered);
  std::cout << '\n' << driftTable(filtered, paths) << std::flush;
  requireObserved(filtered);
  save(resultOf(filtered, options), options.output);
  std::cout << "\nwritten: " << options.output << std::endl;
}

}  // namespace bs_car_odometry::tools
