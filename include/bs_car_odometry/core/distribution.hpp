#pragma once

#include <limits>

namespace bs_car_odometry {

/// Distribution of a random error of mean zero, in the unit of the error. A plain number is the standard
/// deviation of a Gaussian.
class Distribution {
 public:
  enum class Shape { kGaussian, kUniform, kTriangular, kStudentT };

  static constexpr double kNotTruncated = std::numeric_limits<double>::infinity();

  Distribution(double std = 0.0) : scale_(std), std_(std) {}  // NOLINT: a number is a distribution

  Shape shape() const { return shape_; }
  /// Gaussian: standard deviation before truncation; uniform, triangular: half width; Student t: scale.
  double scale() const { return scale_; }
  double degreesOfFreedom() const { return degrees_of_freedom_; }  ///< of Student t
  double truncation() const { return truncation_; }                ///< no error is larger
  double std() const { return std_; }  ///< standard deviation, truncation included
  double variance() const { return std_ * std_; }
  double kurtosis() const { return kurtosis_; }  ///< fourth moment over std^4

 private:
  Shape shape_{Shape::kGaussian};
  double scale_;
  double degrees_of_freedom_{0.0};
  double truncation_{kNotTruncated};
  double std_;
  double kurtosis_{3.0};
};

}  // namespace bs_car_odometry
