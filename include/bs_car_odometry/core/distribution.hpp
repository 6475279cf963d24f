#pragma once

#include <array>
#include <cstddef>
#include <limits>

namespace bs_car_odometry {

/// Distribution of a random error of mean zero, symmetric, in the unit of the error (docs/model.md, section
/// 5.1). A plain number is the standard deviation of a Gaussian.
///
/// Truncation: errors beyond the limit do not occur, those within keep their proportions. It is given in the
/// unit of the error and lies between 0.5 and 1e12 scales: a narrower one leaves a uniform distribution.
class Distribution {
 public:
  enum class Shape { kGaussian, kUniform, kTriangular, kStudentT };

  static constexpr double kNotTruncated = std::numeric_limits<double>::infinity();
  static constexpr double kLeastTruncation = 0.5;     ///< over the scale
  static constexpr double kLargestTruncation = 1e12;  ///< over the scale

  Distribution(double std = 0.0) : scale_(std), std_(std) {}  // NOLINT: a number is a distribution

  /// @param std before truncation
  /// @throws std::invalid_argument here and below for what is negative, not finite or outside the limits
  static Distribution gaussian(double std, double truncation = kNotTruncated);

  /// In [-half_width, half_width].
  static Distribution uniform(double half_width);

  /// In [-half_width, half_width], most likely zero, falling linearly to both sides.
  static Distribution triangular(double half_width);

  /// scale times Student's t.
  /// @param degrees_of_freedom above 2, where the standard deviation is finite; from 1 with a truncation
  static Distribution studentT(double scale, double degrees_of_freedom, double truncation = kNotTruncated);

  Shape shape() const { return shape_; }
  /// Gaussian: standard deviation before truncation; uniform, triangular: half width; Student t: scale.
  double scale() const { return scale_; }
  double degreesOfFreedom() const { return degrees_of_freedom_; }  ///< of Student t
  double truncation() const { return truncation_; }                ///< no error is larger
  double std() const { return std_; }  ///< standard deviation, truncation included
  double variance() const { return std_ * std_; }

  /// Fourth moment over std^4, truncation included; infinite for an untruncated Student t of at most 4
  /// degrees of freedom.
  double kurtosis() const { return moments_[1]; }

  /// The same for any even order from 2 to 8: E[x^order] / std^order, infinite where the tails are too heavy.
  double standardMoment(int order) const { return moments_[static_cast<std::size_t>(order / 2 - 1)]; }

 private:
  using Moments = std::array<double, 4>;  ///< of the orders 2, 4, 6, 8

  Distribution(Shape shape, double scale, double degrees_of_freedom, double truncation);

  void setMoments();

  Shape shape_{Shape::kGaussian};
  double scale_;
  double degrees_of_freedom_{0.0};
  double truncation_{kNotTruncated};
  double std_;
  Moments moments_{1.0, 3.0, 15.0, 105.0};
};

}  // namespace bs_car_odometry
