#include "bs_car_odometry/core/held_errors.hpp"

#include "bs_car_odometry/core/particle_draws.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace bs_car_odometry {

namespace {

/// A step that is longer than so many draws takes most of them as one Gaussian, to which their mean is close.
constexpr double kMostDraws = 32.0;

}  // namespace

/// The particles of a block whose errors have to be drawn anew.
struct HeldErrors::Expired {
  std::size_t count{0};
  BitBlock particle;
  BitBlock place;   ///< in the block
  FloatBlock left;  ///< travel since the error expired [m]
};

HeldErrors::HeldErrors(const Distribution& distribution, double length, std::size_t particles)
    : distribution_(distribution), length_(static_cast<float>(length)) {
  if (distribution.std() == 0.0) return;
  error_.resize(particles);
  remaining_.resize(particles);
}

void HeldErrors::begin(const DrawNumber& number, std::size_t first, std::size_t count) {
  BitBlock particles;
  std::iota(particles.begin(), particles.end(), static_cast<std::uint32_t>(first));
  FloatBlock values;
  draw(distribution_, number, particles.data(), count, values);
  std::copy_n(values.begin(), count, &error_[first]);
  DrawNumber start = number;
  ++start.round;
  draw(Distribution::uniform(0.5), start, particles.data(), count, values);
  for (std::size_t i = 0; i < count; ++i) remaining_[first + i] = length_ * (0.5F + values[i]);
}

void HeldErrors::advance(double travel, const DrawNumber& number, std::size_t first, std::size_t count,
                         FloatBlock& mean) {
  Expired expired;
  expire(static_cast<float>(travel), first, count, mean, expired);
  DrawNumber next = number;
  if (travel > kMostDraws * length_) {
    skipWholeDraws(travel, next, expired, mean);
    ++next.round;
  }
  for (; expired.count > 0; ++next.round) redraw(static_cast<float>(travel), next, first, expired, mean);
}

/// The share of the errors that are there.
void HeldErrors::expire(float travel, std::size_t first, std::size_t count, FloatBlock& mean,
                        Expired& expired) {
  for (std::size_t i = 0; i < count; ++i) {
    mean[i] = error_[first + i];
    const float left = travel - remaining_[first + i];
    remaining_[first + i] -= travel;
    expired.place[expired.count] = static_cast<std::uint32_t>(i);
    expired.left[expired.count] = left;
    expired.count += left > 0.0F ? 1 : 0;  // without a branch, which nobody could predict
  }
  for (std::size_t j = 0; j < expired.count; ++j) {
    const std::uint32_t i = expired.place[j];
    expired.particle[j] = static_cast<std::uint32_t>(first) + i;
    mean[i] *= 1.0F - expired.left[j] / travel;
  }
}

void HeldErrors::skipWholeDraws(double travel, const DrawNumber& number, Expired& expired,
                                FloatBlock& mean) const {
  const double draws = std::floor(travel / length_ - (kMostDraws - 1.0));
  FloatBlock sum;
  draw(Distribution(distribution_.std() * std::sqrt(draws)), number, expired.particle.data(), expired.count,
       sum);
  const auto share = static_cast<float>(length_ / travel);
  const auto skipped = static_cast<float>(draws * length_);
  const float most = static_cast<float>(kMostDraws) * length_;  // whatever the rounding
  for (std::size_t j = 0; j < expired.count; ++j) {
    mean[expired.place[j]] += share * sum[j];
    expired.left[j] = std::clamp(expired.left[j] - skipped, 0.0F, most);
  }
}

/// One new error for each of the expired, of whom those stay whose new one does not last to the step's end.
void HeldErrors::redraw(float travel, const DrawNumber& number, std::size_t first, Expired& expired,
                        FloatBlock& mean) {
  FloatBlock drawn;
  draw(distribution_, number, expired.particle.data(), expired.count, drawn);
  const float per_travel = 1.0F / travel;
  std::size_t kept = 0;
  for (std::size_t j = 0; j < expired.count; ++j) {
    const std::uint32_t i = expired.place[j];
    const float left = expired.left[j];
    mean[i] += std::min(left, length_) * per_travel * drawn[j];
    error_[first + i] = drawn[j];
    remaining_[first + i] = length_ - left;
    expired.particle[kept] = expired.particle[j];
    expired.place[kept] = i;
    expired.left[kept] = left - length_;
    kept += left > length_ ? 1 : 0;
  }
  expired.count = kept;
}

}  // namespace bs_car_odometry
