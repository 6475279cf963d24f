#include "bs_car_odometry/simulation/correlated_error.hpp"

#include <stdexcept>

namespace bs_car_odometry::simulation {

CorrelatedError::CorrelatedError(double std, double length, Random random)
    : std_(std),
      length_(length),
      random_(random),
      value_(std == 0.0 ? 0.0 : std * random_.normal()),
      remaining_(length * random_.uniform()) {
  if (std != 0.0 && !(length > 0.0)) throw std::invalid_argument("correlation length must be positive");
}

double CorrelatedError::advance(double travel) {
  if (std_ == 0.0 || !(travel > 0.0)) return value_;
  double left = travel;
  double sum = 0.0;
  while (left >= remaining_) {
    sum += value_ * remaining_;
    left -= remaining_;
    value_ = std_ * random_.normal();
    remaining_ = length_;
  }
  remaining_ -= left;
  return (sum + value_ * left) / travel;
}

}  // namespace bs_car_odometry::simulation
