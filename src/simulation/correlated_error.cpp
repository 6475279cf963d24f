#include "bs_car_odometry/simulation/correlated_error.hpp"

#include <stdexcept>

namespace bs_car_odometry::simulation {

CorrelatedError::CorrelatedError(const Distribution& error, double length, Random random)
    : error_(error),
      length_(length),
      random_(random),
      value_(error.scale() == 0.0 ? 0.0 : random_.draw(error)),
      remaining_(length * random_.uniform()) {
  if (error.scale() != 0.0 && !(length > 0.0))
    throw std::invalid_argument("correlation length must be positive");
}

double CorrelatedError::advance(double travel) {
  if (error_.scale() == 0.0 || !(travel > 0.0)) return value_;
  double left = travel;
  double sum = 0.0;
  while (left >= remaining_) {
    sum += value_ * remaining_;
    left -= remaining_;
    value_ = random_.draw(error_);
    remaining_ = length_;
  }
  remaining_ -= left;
  return (sum + value_ * left) / travel;
}

}  // namespace bs_car_odometry::simulation
