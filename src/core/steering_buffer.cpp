#include "bs_car_odometry/core/steering_buffer.hpp"

#include <algorithm>

namespace bs_car_odometry {

namespace {

/// Readings among which nearly every search ends: those of the last steps.
constexpr std::ptrdiff_t kNewest = 8;

}  // namespace

SteeringBuffer::SteeringBuffer(std::size_t capacity) : capacity_(std::max<std::size_t>(capacity, 2)) {
  readings_.reserve(2 * capacity_);
}

SteeringBuffer::Iterator SteeringBuffer::firstAfter(Time stamp) const {
  const auto size = static_cast<std::ptrdiff_t>(readings_.size());
  Iterator begin = readings_.end() - std::min(size, kNewest);
  if (begin != readings_.end() && stamp < begin->stamp) begin = readings_.begin();
  return std::upper_bound(begin, readings_.end(), stamp,
                          [](Time time, const Reading& reading) { return time < reading.stamp; });
}

SteeringBuffer::Inserted SteeringBuffer::insert(Time stamp, double angle) {
  if (readings_.size() >= capacity_ && stamp < readings_.front().stamp) return Inserted::kTooOld;
  const Iterator after = firstAfter(stamp);
  if (after != readings_.begin() && std::prev(after)->stamp == stamp) return Inserted::kRepeated;
  readings_.insert(after, {stamp, angle});
  makeRoom();
  return Inserted::kYes;
}

void SteeringBuffer::makeRoom() {
  if (readings_.size() < 2 * capacity_) return;
  readings_.erase(readings_.begin(), readings_.end() - static_cast<std::ptrdiff_t>(capacity_));
}

std::optional<Time> SteeringBuffer::oldest() const {
  if (readings_.empty()) return std::nullopt;
  return readings_.front().stamp;
}

std::optional<Time> SteeringBuffer::newest() const {
  if (readings_.empty()) return std::nullopt;
  return readings_.back().stamp;
}

std::optional<Time> SteeringBuffer::newestUntil(Time stamp) const {
  const Iterator after = firstAfter(stamp);
  if (after == readings_.begin()) return std::nullopt;
  return std::prev(after)->stamp;
}

double SteeringBuffer::angleAt(Time stamp) const {
  const Iterator after = firstAfter(stamp);
  if (after == readings_.begin()) return after->angle;
  const Reading& before = *std::prev(after);
  if (after == readings_.end()) return before.angle;
  const double part = toSeconds(stamp - before.stamp) / toSeconds(after->stamp - before.stamp);
  return before.angle + part * (after->angle - before.angle);
}

}  // namespace bs_car_odometry
