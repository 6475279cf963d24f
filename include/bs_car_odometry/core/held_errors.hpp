#pragma once

#include "bs_car_odometry/core/distribution.hpp"
#include "bs_car_odometry/core/particle_kernels.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bs_car_odometry {

/// The error of one steering angle of every particle: the same for a length of travel, from a start of the
/// particle's own, and then drawn anew (docs/model.md, section 5.6). The starts are spread evenly over the
/// particles of a block, so that those whose error ends in a step stand side by side.
class HeldErrors {
 public:
  /// @param length  correlation length [m]
  HeldErrors(const Distribution& distribution, double length, std::size_t particles);

  bool active() const { return !error_.empty(); }

  /// Begins again; the errors of all particles are to be drawn then.
  void restart() { position_ = 0.0; }
  void begin(const DrawNumber& number, std::size_t first, std::size_t count);

  /// A step that all particles take.
  struct Step {
    double travel{0.0};    ///< [m]
    double position{0.0};  ///< [m] that the first particle of a block had gone since its last draw
  };
  Step take(double travel);

  /// The mean error of each particle of a block over a step, `travel` > 0 [m].
  void advance(const Step& step, const DrawNumber& number, std::size_t first, std::size_t count,
               FloatBlock& mean);

 private:
  struct Range {
    std::size_t begin;
    std::size_t end;
  };

  std::array<Range, 2> ending(const Step& step, std::size_t count) const;
  double sinceEnd(const Step& step, std::size_t place) const;
  void fade(const Step& step, const Range& range, FloatBlock& mean) const;
  double skipDraws(const Step& step, const DrawNumber& number, std::size_t first, const Range& range,
                   FloatBlock& mean) const;
  void redraw(const Step& step, const DrawNumber& number, double past, std::size_t first, const Range& range,
              FloatBlock& mean);

  Distribution distribution_;
  double length_;
  double position_{0.0};      ///< [m] that the first particle of a block has gone since its last draw
  std::vector<float> error_;  ///< [rad]
};

}  // namespace bs_car_odometry
