#include "bs_car_odometry/calibration/rehearsal.hpp"

#include <algorithm>
#include <cmath>

namespace bs_car_odometry::calibration {

namespace {

constexpr double kLast = 16.0;              ///< [m]: gains are then known to some thousandths
constexpr std::size_t kMostEvents = 32768;  ///< 16 m in 30 s at 1 kHz; 6 MB

}  // namespace

void Rehearsal::add(const MeasuredStep& step) {
  double longest = 0.0;
  for (const double travel : step.readings.travel.values) longest = std::max(longest, std::abs(travel));
  distance_ += longest;
  events_.push_back(step);
}

bool Rehearsal::isOver() const { return next_ > kLast || events_.size() > kMostEvents; }

std::unique_ptr<Filter> Rehearsal::repeat(const ParameterVector& values) {
  while (next_ <= distance_) next_ *= 2.0;
  std::unique_ptr<Filter> filter = begun_->clone();
  if (!filter->lineariseAt(values)) {
    next_ = 2.0 * kLast;
    return nullptr;
  }
  for (const auto& event : events_) {
    if (const auto* step = std::get_if<MeasuredStep>(&event)) {
      filter->move(*step);
    } else {
      const Taken& taken = std::get<Taken>(event);
      filter->update(taken.laser, taken.lead);
    }
  }
  filter->lineariseAt(std::nullopt);
  return filter;
}

}  // namespace bs_car_odometry::calibration
