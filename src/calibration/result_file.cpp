#include "bs_car_odometry/calibration/result_file.hpp"

#include "bs_car_odometry/core/systematic_prior.hpp"

#include <Eigen/Eigenvalues>

#include <cmath>

namespace bs_car_odometry::calibration {

std::string faultOf(std::size_t parameter, double value) {
  constexpr double kPi = 3.14159265358979;
  const auto within = [value](double low, double high) { return value >= low && value <= high; };
  if (!std::isfinite(value)) return "is not finite";
  if (isGain(parameter)) return within(0.5, 2.0) ? "" : "is not within 0.5 to 2";
  switch (parameter) {
    case kFrontScale:
    case kRearScale:
      return within(-1000.0, 1000.0) && value != 0.0 ? "" : "is not within -1000 to 1000, and not 0";
    case kLaserX:
    case kLaserY:
      return within(-100.0, 100.0) ? "" : "is not within -100 to 100 m";
    case kLaserYaw:
      return within(-2.0 * kPi, 2.0 * kPi) ? "" : "is not within -6.3 to 6.3 rad";
    case kTimeOffset:
      return within(-10.0, 10.0) ? "" : "is not within -10 to 10 s";
    default:
      return within(-kPi, kPi) ? "" : "is not within -3.1 to 3.1 rad";
  }
}

/// Judged by the correlations, since the parameters have units of their own.
bool isCovariance(const ParameterMatrix& matrix) {
  constexpr double kRounding = 1e-9;
  constexpr double kLargestVariance = 1e4;  // (100 m)^2; what is far larger overflows further on
  if (!matrix.allFinite() || matrix.diagonal().minCoeff() < 0.0) return false;
  if (matrix.diagonal().maxCoeff() > kLargestVariance) return false;
  const ParameterVector deviations = matrix.diagonal().cwiseSqrt();
  ParameterMatrix correlations = ParameterMatrix::Identity();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
      const double scale = deviations[i] * deviations[j];
      if (std::abs(matrix(i, j) - matrix(j, i)) > kRounding * scale) return false;
      if (std::abs(matrix(i, j)) > (1.0 + kRounding) * scale) return false;
      if (i != j && scale > 0.0) correlations(i, j) = matrix(i, j) / scale;
    }
  const Eigen::SelfAdjointEigenSolver<ParameterMatrix> solver(correlations, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().minCoeff() >= -kRounding;
}

void writeCalibrationFile(const std::string& path, const CalibrationResult& result,
                          const Parameters& parameters) {
  writeAtomically(path, toText(result, parameters));
}

CalibrationResult readCalibrationFile(const std::string& path, const Parameters& parameters) {
  try {
    return fromText(readSmallFile(path, kLargestFile), parameters);
  } catch (const CalibrationFileError& error) {
    throw CalibrationFileError(path + " is not used: " + error.what());
  } catch (const FileError& error) {
    throw CalibrationFileError(error.what());
  }
}

void replaceBlock(const CalibrationResult& result, SystematicCovariance& covariance) {
  for (std::size_t i = 0; i < systematic::kCount; ++i)
    for (std::size_t j = 0; j < systematic::kCount; ++j) {
      if (!result.listed[i] && !result.listed[j]) continue;
      const auto row = static_cast<Eigen::Index>(i);
      const auto column = static_cast<Eigen::Index>(j);
      const bool both = result.listed[i] && result.listed[j];
      covariance(row, column) =
          both ? 0.5 * (result.covariance(row, column) + result.covariance(column, row)) : 0.0;
    }
}

void applyCalibration(const CalibrationResult& result, Parameters& parameters) {
  ParameterVector values = valuesOf(parameters);
  for (std::size_t i = 0; i < kCount; ++i)
    if (result.listed[i]) values[static_cast<Eigen::Index>(i)] = result.values[static_cast<Eigen::Index>(i)];
  setValues(values, parameters);
  SystematicCovariance covariance =
      parameters.systematic_covariance.value_or(systematicCovariance(parameters.noise.systematic));
  replaceBlock(result, covariance);
  parameters.systematic_covariance = covariance;
}

std::string applyCalibrationFile(Parameters& parameters) {
  const std::string& path = parameters.calibration_file;
  try {
    if (!path.empty()) {
      applyCalibration(readCalibrationFile(path, parameters), parameters);
    } else if (parameters.require_calibration) {
      throw CalibrationFileError(
          "require_calibration is true, and calibration_file names no file; name one, or calibrate first");
    }
  } catch (const CalibrationFileError& error) {
    if (parameters.require_calibration) throw;
    return error.what();
  }
  return "";
}

}  // namespace bs_car_odometry::calibration
