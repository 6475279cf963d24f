#include "bs_car_odometry/core/distribution.hpp"

#include <array>
#include <cmath>
#include <stdexcept>

namespace bs_car_odometry {

namespace {

/// Density of the shape with scale 1 at x, but for a factor.
double density(Distribution::Shape shape, double degrees_of_freedom, double x) {
  if (shape == Distribution::Shape::kGaussian) return std::exp(-0.5 * x * x);
  return std::exp(-0.5 * (degrees_of_freedom + 1.0) * std::log1p(x * x / degrees_of_freedom));
}

/// Moments with scale 1 within [-limit, limit], by Gauss-Legendre in panels of u with x = sinh(u): fine where
/// the density is, and still short where a heavy tail reaches far.
std::array<double, 4> truncatedMoments(Distribution::Shape shape, double degrees_of_freedom, double limit) {
  constexpr std::array<double, 5> kNodes{-0.906179845938664, -0.5384693101056831, 0.0, 0.5384693101056831,
                                         0.906179845938664};
  constexpr std::array<double, 5> kWeights{0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                           0.4786286704993665, 0.2369268850561891};
  constexpr double kPanel = 0.125;
  const double end = std::asinh(limit);
  const int panels = static_cast<int>(std::ceil(end / kPanel));
  const double half = 0.5 * end / panels;
  double mass = 0.0;
  std::array<double, 4> moments{};
  for (int panel = 0; panel < panels; ++panel) {
    for (std::size_t i = 0; i < kNodes.size(); ++i) {
      const double u = half * (2.0 * panel + 1.0 + kNodes[i]);
      const double x = std::sinh(u);
      const double share = kWeights[i] * density(shape, degrees_of_freedom, x) * std::cosh(u);
      mass += share;
      double power = share;
      for (double& moment : moments) moment += power *= x * x;
    }
  }
  for (double& moment : moments) moment /= mass;
  return moments;
}

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

/// E[t^order] of Student's t.
double studentMoment(double dof, int order) {
  double moment = 1.0;
  for (int k = 1; k <= order / 2; ++k) {
    if (dof <= 2.0 * k) return std::numeric_limits<double>::infinity();
    moment *= dof * (2.0 * k - 1.0) / (dof - 2.0 * k);
  }
  return moment;
}

/// E[x^order] with scale 1, not truncated.
double moment(Distribution::Shape shape, double degrees_of_freedom, int order) {
  switch (shape) {
    case Distribution::Shape::kUniform:
      return 1.0 / (order + 1.0);
    case Distribution::Shape::kTriangular:
      return 2.0 / ((order + 1.0) * (order + 2.0));
    case Distribution::Shape::kStudentT:
      return studentMoment(degrees_of_freedom, order);
    case Distribution::Shape::kGaussian:
      break;
  }
  double product = 1.0;
  for (int factor = 1; factor < order; factor += 2) product *= factor;
  return product;
}

}  // namespace

Distribution::Distribution(Shape shape, double scale, double degrees_of_freedom, double truncation)
    : shape_(shape),
      scale_(scale),
      degrees_of_freedom_(degrees_of_freedom),
      truncation_(truncation),
      std_(0.0) {
  require(std::isfinite(scale) && scale >= 0.0, "the scale of a distribution must be finite, not negative");
  require(truncation == kNotTruncated || (truncation > 0.0 && truncation >= kLeastTruncation * scale &&
                                          (scale == 0.0 || truncation <= kLargestTruncation * scale)),
          "a truncation must lie between 0.5 and 1e12 times the scale");
  setMoments();
}

Distribution Distribution::gaussian(double std, double truncation) {
  return {Shape::kGaussian, std, 0.0, truncation};
}

Distribution Distribution::uniform(double half_width) {
  return {Shape::kUniform, half_width, 0.0, kNotTruncated};
}

Distribution Distribution::triangular(double half_width) {
  return {Shape::kTriangular, half_width, 0.0, kNotTruncated};
}

Distribution Distribution::studentT(double scale, double degrees_of_freedom, double truncation) {
  const bool truncated = truncation != kNotTruncated;
  require(
      std::isfinite(degrees_of_freedom) && (truncated ? degrees_of_freedom >= 1.0 : degrees_of_freedom > 2.0),
      "a Student t needs more than 2 degrees of freedom, or at least 1 and a truncation");
  return {Shape::kStudentT, scale, degrees_of_freedom, truncation};
}

void Distribution::setMoments() {
  const bool truncated = truncation_ != kNotTruncated;
  const double unit = scale_ > 0.0 ? scale_ : truncation_;  // no scale: the moments are any, the error zero
  if (truncated) moments_ = truncatedMoments(shape_, degrees_of_freedom_, truncation_ / unit);
  if (!truncated)
    for (std::size_t i = 0; i < moments_.size(); ++i)
      moments_[i] = moment(shape_, degrees_of_freedom_, 2 * static_cast<int>(i) + 2);
  const double variance = moments_[0];
  std_ = scale_ * std::sqrt(variance);
  for (std::size_t i = 0; i < moments_.size(); ++i)
    moments_[i] /= std::pow(variance, static_cast<double>(i) + 1.0);
}

}  // namespace bs_car_odometry
