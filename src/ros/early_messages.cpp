#include "bs_car_odometry/ros/early_messages.hpp"

#include <utility>

namespace bs_car_odometry {

namespace {

constexpr std::size_t kMostKept = 1000;  // as long as that takes, at 1 kHz and more
constexpr double kPatience = 0.1;        // [s] of a clock that comes ten times a second
constexpr double kPeriod = 0.005;        // [s] between looks at the clock

}  // namespace

EarlyMessages::EarlyMessages(const ros::NodeHandle& node, const std::function<void()>& look)
    : timer_(node.createWallTimer(
          ros::WallDuration(kPeriod), [look](const ros::WallTimerEvent&) { look(); }, false, false)) {}

bool EarlyMessages::keep(const Delivery& delivery) {
  if (all_are_late_ || kept_.size() >= kMostKept) return false;
  if (kept_.empty()) {
    since_ = ros::SteadyTime::now();
    timer_.start();
  }
  kept_.push_back(delivery);
  return true;
}

void EarlyMessages::deliver() {
  timer_.stop();
  for (const Delivery& delivery : std::exchange(kept_, {})) delivery();
}

void EarlyMessages::deliverLate() {
  if (kept_.empty() || (ros::SteadyTime::now() - since_).toSec() < kPatience) return;
  all_are_late_ = true;
  deliver();
}

}  // namespace bs_car_odometry
