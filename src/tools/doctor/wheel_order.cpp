#include "wheel_order.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace bs_car_odometry::tools::doctor {

namespace {

constexpr double kSmallestFactor = 0.8;
constexpr double kLargestFactor = 1.25;
/// What is left open of a wheel's size while orders are compared.
constexpr double kGainSpread = 0.1;
/// Motion of the body is known to that [m] in each window at best; differences between wheels, in which the
/// laser's position drops out, are known better.
constexpr double kCommonFloor = 0.01;
constexpr double kDifferenceFloor = 0.005;
/// Logarithms of likelihood: an order must be so much likelier; a wheel that runs backwards, one whose size
/// is wrong, and one in another's place are assumed only for a reason.
constexpr double kDecision = 15.0;
constexpr double kInvertedCost = 3.0;
constexpr double kGrossCost = 12.0;

using Table = std::vector<PerWheel<double>>;

Table expectedTravels(const Vehicle& vehicle, const std::vector<MotionWindow>& windows) {
  Table expected;
  for (const MotionWindow& window : windows) expected.push_back(expectedTravel(vehicle, window.motion));
  return expected;
}

double fittedFactor(const std::vector<MotionWindow>& windows, const Table& expected, Wheel wheel,
                    Wheel place) {
  double product = 0.0;
  double square = 1e-12;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    product += windows[i].travel[wheel] * expected[i][place];
    square += expected[i][place] * expected[i][place];
  }
  return product / square;
}

/// The factor with which readings are compared: as fitted when it is gross, else within a tyre's range.
double usedFactor(double fitted) {
  if (isGross(fitted)) return fitted;
  const double size = std::clamp(std::abs(fitted), 1.0 - kGainSpread, 1.0 + kGainSpread);
  return fitted < 0.0 ? -size : size;
}

/// Squares of what an order leaves over: of the mean of all wheels, and of each wheel against that mean.
struct Leftover {
  double common{0.0};
  double difference{0.0};
};

Leftover leftoverOf(const std::vector<MotionWindow>& windows, const Table& expected,
                    const WheelOrder& order) {
  const double n = static_cast<double>(order.wheels.size());
  Leftover sum;
  std::vector<double> errors(order.wheels.size());
  for (std::size_t i = 0; i < windows.size(); ++i) {
    double mean = 0.0;
    for (std::size_t w = 0; w < errors.size(); ++w) {
      const Wheel wheel = order.wheels[w];
      errors[w] = windows[i].travel[wheel] / order.factor[wheel] - expected[i][order.place[w]];
      mean += errors[w] / n;
    }
    sum.common += mean * mean;
    for (const double error : errors) sum.difference += (error - mean) * (error - mean);
  }
  return sum;
}

double assumptionsOf(const WheelOrder& order) {
  double cost = 0.0;
  for (std::size_t w = 0; w < order.wheels.size(); ++w) {
    const double factor = order.factor[order.wheels[w]];
    if (factor < 0.0) cost += kInvertedCost;
    if (isGross(factor)) cost += kGrossCost;
  }
  return cost;
}

std::size_t movedWheels(const WheelOrder& order) {
  std::size_t moved = 0;
  for (std::size_t w = 0; w < order.wheels.size(); ++w) moved += order.place[w] != order.wheels[w] ? 1 : 0;
  return moved;
}

double costOf(const std::vector<MotionWindow>& windows, const Table& expected, const WheelOrder& order) {
  const double n = static_cast<double>(windows.size());
  const double freedom = static_cast<double>(order.wheels.size() - 1);
  const Leftover leftover = leftoverOf(windows, expected, order);
  return 0.5 * n * std::log(leftover.common / n + kCommonFloor * kCommonFloor) +
         0.5 * n * freedom *
             std::log(leftover.difference / (n * freedom) + kDifferenceFloor * kDifferenceFloor) +
         assumptionsOf(order);
}

}  // namespace

bool isGross(double factor) {
  return std::abs(factor) < kSmallestFactor || std::abs(factor) > kLargestFactor;
}

PerWheel<double> expectedTravel(const Vehicle& vehicle, const BodyMotion& motion) {
  PerWheel<double> expected;
  for (const Wheel wheel : kAllWheels) {
    const Axle axle = axleOf(wheel);
    const double y = (isLeft(wheel) ? 0.5 : -0.5) * vehicle.calibratedTrack(axle);
    const double ahead = motion.x() - motion.z() * y;
    const double aside = motion.y() + motion.z() * vehicle.axleX(axle);
    expected[wheel] = std::copysign(std::hypot(ahead, aside), ahead);
  }
  return expected;
}

PerWheel<WheelFactor> wheelFactors(const Vehicle& vehicle, const std::vector<MotionWindow>& windows) {
  const Table expected = expectedTravels(vehicle, windows);
  PerWheel<WheelFactor> factors;
  for (const Wheel wheel : kAllWheels) {
    factors[wheel].factor = fittedFactor(windows, expected, wheel, wheel);
    for (const MotionWindow& window : windows) factors[wheel].rolled += std::abs(window.travel[wheel]);
  }
  return factors;
}

WheelOrder findWheelOrder(const Vehicle& vehicle, const std::vector<MotionWindow>& windows,
                          const std::vector<Wheel>& wheels) {
  const Table expected = expectedTravels(vehicle, windows);
  WheelOrder tried{wheels, wheels, {}};
  std::vector<std::pair<double, WheelOrder>> orders;
  double least = std::numeric_limits<double>::infinity();
  do {
    for (std::size_t w = 0; w < wheels.size(); ++w)
      tried.factor[wheels[w]] = usedFactor(fittedFactor(windows, expected, wheels[w], tried.place[w]));
    orders.emplace_back(costOf(windows, expected, tried), tried);
    least = std::min(least, orders.back().first);
  } while (std::next_permutation(tried.place.begin(), tried.place.end()));
  const auto rank = [&](const std::pair<double, WheelOrder>& order) {
    return std::tuple(order.first > least + kDecision, movedWheels(order.second), order.first);
  };
  return std::min_element(orders.begin(), orders.end(),
                          [&](const auto& a, const auto& b) { return rank(a) < rank(b); })
      ->second;
}

}  // namespace bs_car_odometry::tools::doctor
