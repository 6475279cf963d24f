#include "stamp_statistics.hpp"

namespace bs_car_odometry::tools::doctor {

bool StampStatistics::add(std::optional<Time> stamp, Time record) {
  ++messages_;
  if (!stamp || *stamp == Time()) {
    ++zero_;
    return false;
  }
  offsets_.add(toSeconds(record - *stamp));
  if (isAhead(*stamp, record) || !follows(*stamp)) return false;
  noteInterval(*stamp);
  if (!first_) first_ = stamp;
  last_ = stamp;
  return true;
}

bool StampStatistics::isAhead(Time stamp, Time record) {
  if (stamp <= record + limits_.max_future) return false;
  ++future_;
  return true;
}

bool StampStatistics::follows(Time stamp) {
  if (!last_ || stamp > *last_) return true;
  if (stamp == *last_) {
    ++repeated_;
  } else {
    ++backwards_;
    furthest_back_ = std::max(furthest_back_, *last_ - stamp);
  }
  return false;
}

void StampStatistics::noteInterval(Time stamp) {
  if (!last_) return;
  const Duration interval = stamp - *last_;
  intervals_.add(toSeconds(interval));
  if (interval > limits_.max_gap) ++gaps_;
  if (interval <= longest_) return;
  longest_ = interval;
  longest_at_ = *last_;
}

double StampStatistics::rate() const {
  const double median = intervals_.quantile(0.5);
  return median > 0.0 ? 1.0 / median : 0.0;
}

}  // namespace bs_car_odometry::tools::doctor
