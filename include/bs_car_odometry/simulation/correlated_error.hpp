#pragma once

#include "bs_car_odometry/simulation/random.hpp"

namespace bs_car_odometry::simulation {

/// An error of a distribution that keeps its value for a length of travel and is then drawn anew
/// (docs/model.md, section 5.1). The first change comes at a uniform place within the first length, so the
/// process has no special places: its mean over d metres has variance std^2 (1 - d/(3l)) for d <= l, std^2
/// (l/d)(1 - l/(3d)) for d >= l.
class CorrelatedError {
 public:
  /// @param error [its own unit]  @param length l [m], positive
  CorrelatedError(const Distribution& error, double length, Random random);

  double value() const { return value_; }

  /// Moves on by `travel` >= 0 [m].
  /// @return the mean error over that travel; the present value where there is none
  double advance(double travel);

 private:
  Distribution error_;
  double length_;
  Random random_;
  double value_;
  double remaining_;  ///< [m] to the next draw
};

}  // namespace bs_car_odometry::simulation
