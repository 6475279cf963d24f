#pragma once

#include <array>
#include <cstddef>

namespace bs_car_odometry {

/// The wheels, always in this order; left and right as seen by the driver.
enum class Wheel { kFrontLeft = 0, kFrontRight = 1, kRearLeft = 2, kRearRight = 3 };
enum class Axle { kFront = 0, kRear = 1 };

constexpr std::size_t kWheels = 4;
constexpr std::size_t kAxles = 2;

constexpr std::array<Wheel, kWheels> kAllWheels{Wheel::kFrontLeft, Wheel::kFrontRight, Wheel::kRearLeft,
                                                Wheel::kRearRight};
constexpr std::array<Axle, kAxles> kAllAxles{Axle::kFront, Axle::kRear};

constexpr std::size_t index(Wheel wheel) { return static_cast<std::size_t>(wheel); }
constexpr std::size_t index(Axle axle) { return static_cast<std::size_t>(axle); }

constexpr Axle axleOf(Wheel wheel) { return index(wheel) < 2 ? Axle::kFront : Axle::kRear; }
constexpr bool isLeft(Wheel wheel) { return index(wheel) % 2 == 0; }
constexpr Wheel leftWheel(Axle axle) { return axle == Axle::kFront ? Wheel::kFrontLeft : Wheel::kRearLeft; }
constexpr Wheel rightWheel(Axle axle) {
  return axle == Axle::kFront ? Wheel::kFrontRight : Wheel::kRearRight;
}

constexpr const char* name(Wheel wheel) {
  if (isLeft(wheel)) return axleOf(wheel) == Axle::kFront ? "front_left" : "rear_left";
  return axleOf(wheel) == Axle::kFront ? "front_right" : "rear_right";
}
constexpr const char* name(Axle axle) { return axle == Axle::kFront ? "front" : "rear"; }

/// One value for each wheel, addressed by `Wheel`.
template <typename T>
struct PerWheel {
  std::array<T, kWheels> values{};
  constexpr T& operator[](Wheel wheel) { return values[index(wheel)]; }
  constexpr const T& operator[](Wheel wheel) const { return values[index(wheel)]; }
  friend bool operator==(const PerWheel& a, const PerWheel& b) { return a.values == b.values; }
};

/// One value for each axle, addressed by `Axle`.
template <typename T>
struct PerAxle {
  T front{};
  T rear{};
  constexpr T& operator[](Axle axle) { return axle == Axle::kFront ? front : rear; }
  constexpr const T& operator[](Axle axle) const { return axle == Axle::kFront ? front : rear; }
};

}  // namespace bs_car_odometry
