#pragma once

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

// Predicates for EXPECT_TRUE that say by how much they failed.
namespace bs_car_odometry::test_support {

inline testing::AssertionResult relativelyNear(double value, double expected, double tolerance) {
  const double error = std::abs(value - expected);
  if (error <= tolerance * std::abs(expected)) return testing::AssertionSuccess();
  return testing::AssertionFailure() << value << " against " << expected << ", relative error "
                                     << error / std::abs(expected) << " > " << tolerance;
}

/// Every entry within `tolerance` of the other's, absolutely.
template <typename A, typename B>
testing::AssertionResult matrixNear(const Eigen::MatrixBase<A>& value, const Eigen::MatrixBase<B>& expected,
                                    double tolerance) {
  const Eigen::MatrixXd error = (value - expected).cwiseAbs();
  if ((error.array() <= tolerance).all()) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "largest error " << error.maxCoeff() << " > " << tolerance << "\n"
                                     << value << "\nagainst\n"
                                     << expected;
}

/// Every entry within `tolerance` of the other's, relative to the expected entry, or to the largest expected
/// entry where zero is expected.
template <typename A, typename B>
testing::AssertionResult matrixRelativelyNear(const Eigen::MatrixBase<A>& value,
                                              const Eigen::MatrixBase<B>& expected, double tolerance) {
  const Eigen::ArrayXXd wanted = expected.array();
  const double largest = wanted.abs().maxCoeff();
  const Eigen::ArrayXXd scale = (wanted == 0.0).select(largest, wanted.abs());
  const Eigen::ArrayXXd error = (value.array() - wanted).abs() / scale;
  if ((error <= tolerance).all()) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "largest relative error " << error.maxCoeff() << " > " << tolerance
                                     << "\n"
                                     << value << "\nagainst\n"
                                     << expected;
}

/// Exactly symmetric and, but for rounding, without a negative eigenvalue.
inline testing::AssertionResult isCovariance(const Eigen::Matrix3d& matrix) {
  if (!matrix.allFinite()) return testing::AssertionFailure() << "not finite:\n" << matrix;
  if (matrix != matrix.transpose()) return testing::AssertionFailure() << "not symmetric:\n" << matrix;
  const Eigen::Vector3d eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  // An eigenvalue is found to about 1e-16 of the largest one.
  if (eigenvalues(0) < -1e-14 * std::max(eigenvalues(2), 0.0))
    return testing::AssertionFailure() << "eigenvalues " << eigenvalues.transpose();
  return testing::AssertionSuccess();
}

/// The upper triangle row by row.
inline Eigen::Matrix3d symmetric(double xx, double xy, double xt, double yy, double yt, double tt) {
  Eigen::Matrix3d matrix;
  matrix << xx, xy, xt, xy, yy, yt, xt, yt, tt;
  return matrix;
}

}  // namespace bs_car_odometry::test_support
