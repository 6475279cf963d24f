#pragma once

#include "bs_car_odometry/core/distribution.hpp"
#include "bs_car_odometry/core/particle_kernels.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace bs_car_odometry {

/// The error of one steering angle of every particle: the same for a length of travel, from a start of the
/// particle's own, and then drawn anew (docs/model.md, section 5.6).
class HeldErrors {
 public:
  /// @param length  correlation length [m]
  HeldErrors(const Distribution& distribution, double length, std::size_t particles);

  bool active() const { return !error_.empty(); }

  /// Draws the errors, and how long each of them will last.
  void begin(const DrawNumber& number, std::size_t first, std::size_t count);

  /// The mean error of each particle over `travel` > 0 [m].
  void advance(double travel, const DrawNumber& number, std::size_t first, std::size_t count,
               FloatBlock& mean);

 private:
  struct Expired;

  void expire(float travel, std::size_t first, std::size_t count, FloatBlock& mean, Expired& expired);
  void skipWholeDraws(double travel, const DrawNumber& number, Expired& expired, FloatBlock& mean) const;
  void redraw(float travel, const DrawNumber& number, std::size_t first, Expired& expired, FloatBlock& mean);

  Distribution distribution_;
  float length_;
  std::vector<float> error_;      ///< [rad]
  std::vector<float> remaining_;  ///< travel [m] until the next draw
};

}  // namespace bs_car_odometry
