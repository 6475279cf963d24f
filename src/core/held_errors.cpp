#include "bs_car_odometry/core/held_errors.hpp"

#include "bs_car_odometry/core/particle_draws.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace bs_car_odometry {

namespace {

/// A step that is longer than so many draws takes most of them as one Gaussian, to which their mean is close.
constexpr double kMostDraws = 32.0;

/// Share of a length by which a particle is ahead of the first of its block.
constexpr double lead(std::size_t place) {
  return (static_cast<double>(place) + 0.5) / static_cast<double>(kParticleBlock);
}

/// The first place whose lead is at least this.
std::size_t placeOf(double share, std::size_t count) {
  const double place = std::ceil(share * static_cast<double>(kParticleBlock) - 0.5);
  return static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(count)));
}

}  // namespace

HeldErrors::HeldErrors(const Distribution& distribution, double length, std::size_t particles)
    : distribution_(distribution), length_(length) {
  if (distribution.std() > 0.0) error_.resize(particles);
}

void HeldErrors::begin(const DrawNumber& number, std::size_t first, std::size_t count) {
  BitBlock particles;
  std::iota(particles.begin(), particles.end(), static_cast<std::uint32_t>(first));
  FloatBlock values;
  draw(distribution_, number, particles.data(), count, values);
  std::copy_n(values.begin(), count, &error_[first]);
}

HeldErrors::Step HeldErrors::take(double travel) {
  const Step step{travel, position_};
  position_ = std::fmod(position_ + travel, length_);
  return step;
}

/// Particles of a block whose errors end in a step that is shorter than a length: of those that are ahead of
/// the first one's draw, and of those whose lead had already taken them into the next.
std::array<HeldErrors::Range, 2> HeldErrors::ending(const Step& step, std::size_t count) const {
  const double before = step.position / length_;
  const double after = (step.position + step.travel) / length_;
  return {Range{placeOf(1.0 - after, count), placeOf(1.0 - before, count)},
          Range{placeOf(2.0 - after, count), count}};
}

/// Travel of the step after the end of the error of before [m].
double HeldErrors::sinceEnd(const Step& step, std::size_t place) const {
  const double gone = step.position + length_ * lead(place);
  return std::max(step.travel + gone - (gone < length_ ? length_ : 2.0 * length_), 0.0);
}

void HeldErrors::advance(const Step& step, const DrawNumber& number, std::size_t first, std::size_t count,
                         FloatBlock& mean) {
  std::copy_n(&error_[first], count, mean.begin());
  if (step.travel < length_) {
    for (const Range& range : ending(step, count)) {
      fade(step, range, mean);
      redraw(step, number, 0.0, first, range, mean);
    }
    return;
  }
  const Range all{0, count};
  fade(step, all, mean);
  DrawNumber next = number;
  double past = skipDraws(step, next, first, all, mean);
  const int rounds = static_cast<int>(std::min(std::ceil(step.travel / length_), kMostDraws)) + 1;
  for (int round = 0; round < rounds; ++round) {
    ++next.round;
    redraw(step, next, past, first, all, mean);
    past += length_;
  }
}

/// The share that the errors of before have in the mean.
void HeldErrors::fade(const Step& step, const Range& range, FloatBlock& mean) const {
  for (std::size_t i = range.begin; i < range.end; ++i)
    mean[i] *= static_cast<float>(1.0 - sinceEnd(step, i) / step.travel);
}

/// @return the travel that the skipped draws take [m]
double HeldErrors::skipDraws(const Step& step, const DrawNumber& number, std::size_t first,
                             const Range& range, FloatBlock& mean) const {
  const double draws = std::floor(step.travel / length_ - (kMostDraws - 1.0));
  if (draws <= 0.0) return 0.0;
  BitBlock particles;
  std::iota(particles.begin(), particles.end(), static_cast<std::uint32_t>(first));
  FloatBlock sum;
  draw(Distribution(distribution_.std() * std::sqrt(draws)), number, particles.data(), range.end, sum);
  const auto share = static_cast<float>(length_ / step.travel);
  for (std::size_t i = range.begin; i < range.end; ++i) mean[i] += share * sum[i];
  return draws * length_;
}

/// One new error for each of the range, from `past` after the end of the one before on, if the step gets
/// there.
void HeldErrors::redraw(const Step& step, const DrawNumber& number, double past, std::size_t first,
                        const Range& range, FloatBlock& mean) {
  if (range.begin >= range.end) return;
  const std::size_t count = range.end - range.begin;
  BitBlock particles;
  std::iota(particles.begin(), particles.end(), static_cast<std::uint32_t>(first + range.begin));
  FloatBlock drawn;
  draw(distribution_, number, particles.data(), count, drawn);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = range.begin + k;
    const double over = sinceEnd(step, i) - past;
    mean[i] += static_cast<float>(std::clamp(over, 0.0, length_) / step.travel) * drawn[k];
    error_[first + i] = over >= 0.0 ? drawn[k] : error_[first + i];
  }
}

}  // namespace bs_car_odometry
