#include "bs_car_odometry/ros/calibration_acceptance.hpp"

#include "bs_car_odometry/calibration/result_file.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry {

using calibration::CalibrationResult;

namespace {

/// A value is new when it has moved by this share of its standard deviation, or when that has changed by this
/// share of itself. Less would make no difference, ten times a second.
constexpr double kNews = 0.1;

/// What moves the car and is observed.
CalibrationResult observedPart(const CalibrationState& message) {
  CalibrationResult result;
  for (std::size_t i = 0; i < calibration::kMotionCount; ++i) result.listed[i] = message.observed[i] != 0;
  for (std::size_t i = 0; i < calibration::kCount; ++i)
    result.values[static_cast<Eigen::Index>(i)] = message.value[i];
  using Rows = Eigen::Matrix<double, calibration::kCount, calibration::kCount, Eigen::RowMajor>;
  result.covariance = Eigen::Map<const Rows>(message.covariance.data());
  return result;
}

std::string faultOf(const CalibrationResult& result) {
  for (std::size_t i = 0; i < calibration::kMotionCount; ++i) {
    if (!result.listed[i]) continue;
    const std::string fault = calibration::faultOf(i, result.values[static_cast<Eigen::Index>(i)]);
    if (!fault.empty()) return calibration::parameterName(i) + " " + fault;
  }
  if (!calibration::isCovariance(result.covariance))
    return "its covariance is not finite, symmetric and positive semidefinite";
  return "";
}

}  // namespace

static_assert(std::size_t{CalibrationState::PARAMETERS} == std::size_t{calibration::kCount}, "all of them");

CalibrationAcceptance::CalibrationAcceptance(const Parameters& parameters)
    : parameters_(parameters), vehicle_checksum_(calibration::vehicleChecksum(parameters)) {}

CalibrationAcceptance::Answer CalibrationAcceptance::take(const CalibrationState& message,
                                                          const OdometryCalibration& in_use) {
  if (message.vehicle != parameters_.vehicle.name || message.vehicle_checksum != vehicle_checksum_)
    return {"it is another car's: load one vehicle file into odometry and calibration", std::nullopt};
  const CalibrationResult result = observedPart(message);
  const auto& listed = result.listed;
  if (std::none_of(listed.begin(), listed.end(), [](bool observed) { return observed; })) return {};
  const std::string fault = faultOf(result);
  if (!fault.empty()) return {fault + ": start the calibration anew", std::nullopt};
  if (!isNews(result)) return {};
  newest_ = result;
  ++taken_;
  return {"", merged(result, in_use)};
}

bool CalibrationAcceptance::isNews(const CalibrationResult& result) const {
  for (std::size_t i = 0; i < calibration::kMotionCount; ++i) {
    if (!result.listed[i]) continue;
    if (!newest_.listed[i]) return true;
    const auto k = static_cast<Eigen::Index>(i);
    const double deviation = std::sqrt(result.covariance(k, k));
    const double before = std::sqrt(newest_.covariance(k, k));
    if (std::abs(deviation - before) > kNews * before) return true;
    if (std::abs(result.values[k] - newest_.values[k]) > kNews * deviation) return true;
  }
  return false;
}

OdometryCalibration CalibrationAcceptance::merged(const CalibrationResult& result,
                                                  const OdometryCalibration& in_use) {
  Vehicle& vehicle = parameters_.vehicle;
  vehicle.gains = in_use.gains;
  vehicle.steering = in_use.steering;
  parameters_.systematic_covariance = in_use.covariance;
  calibration::applyCalibration(result, parameters_);
  return {vehicle.gains, vehicle.steering, *parameters_.systematic_covariance};
}

}  // namespace bs_car_odometry
