#pragma once

#include "bs_car_odometry/core/distribution.hpp"
#include "bs_car_odometry/core/particle_kernels.hpp"

#include <cstddef>
#include <cstdint>

namespace bs_car_odometry {

/// One draw of a distribution for each of some particles.
/// @param number     its attempt is left to this function
/// @param particles  `count` of them, at most kParticleBlock
void draw(const Distribution& distribution, const DrawNumber& number, const std::uint32_t* particles,
          std::size_t count, FloatBlock& values);

/// The same divided by the standard deviation; zero where that is zero.
void drawStandardised(const Distribution& distribution, const DrawNumber& number,
                      const std::uint32_t* particles, std::size_t count, FloatBlock& values);

}  // namespace bs_car_odometry
