#include "bs_car_odometry/ros/publisher_watch.hpp"

namespace bs_car_odometry {

namespace {

constexpr Duration kSilence = std::chrono::seconds(1);

}  // namespace

bool PublisherWatch::isRival(const Sender& sender) const {
  if (!heard_ || sender.name == name_) return false;
  // A clock that went back says nothing of a silence, and must not prolong one.
  return newest_ <= sender.heard && sender.heard - newest_ < kSilence;
}

void PublisherWatch::hear(const Sender& sender) {
  if (!heard_ || sender.name != name_) name_ = sender.name;
  newest_ = sender.heard;
  heard_ = true;
}

}  // namespace bs_car_odometry
