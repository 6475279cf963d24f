#include "bs_car_odometry/calibration/distance_gain_filter.hpp"

#include "bs_car_odometry/calibration/filter.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::calibration {

DistanceGainFilter::DistanceGainFilter(double k_d, double variance) : state_(0.0, k_d) {
  covariance_(1, 1) = variance;
}

void DistanceGainFilter::begin(double variance) {
  state_(0) = 0.0;
  covariance_.row(0).setZero();
  covariance_.col(0).setZero();
  covariance_(0, 0) = variance;
}

void DistanceGainFilter::move(double travel, double variance) {
  Eigen::Matrix2d F;
  F << 1.0, travel, 0.0, 1.0;
  state_ = F * state_;
  covariance_ = F * covariance_ * F.transpose();
  covariance_(0, 0) += variance;
}

double DistanceGainFilter::update(double distance, double variance) {
  const double residual = distance - state_(0);
  const double square = residual * residual / (covariance_(0, 0) + variance);
  if (!std::isfinite(square)) return 0.0;
  const double weight = std::min(1.0, kSoftLimit / square);
  const double R = variance / weight;
  const Eigen::Vector2d K = covariance_.col(0) / (covariance_(0, 0) + R);
  state_ += K * residual;
  Eigen::Matrix2d J = Eigen::Matrix2d::Identity();  // Joseph form: stays a covariance
  J.col(0) -= K;
  covariance_ = J * covariance_ * J.transpose() + R * K * K.transpose();
  return weight;
}

}  // namespace bs_car_odometry::calibration
