#pragma once

#include <ros/message_traits.h>

namespace bs_car_odometry {

/// A trait of a type that goes over the wire as a `Message` does: Trait<Message>'s answer.
template <template <typename> class Trait, typename Message, typename Type>
struct TraitOf {
  static const char* value(const Type& /*message*/) { return value(); }
  static const char* value() { return Trait<Message>::value(); }
};

}  // namespace bs_car_odometry
