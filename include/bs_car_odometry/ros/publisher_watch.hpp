#pragma once

#include "bs_car_odometry/core/time.hpp"

#include <string>
#include <string_view>

namespace bs_car_odometry {

/// Who sent a message, and when it was heard; without a name where that is not known, as in some bags.
struct Sender {
  std::string_view name;
  Time heard;
};

/// Keeps an input to its first publisher (docs/reliability.md, E10). Nodes have names, and a driver that is
/// started again has its old one, or speaks after a silence. Publishers within one process cannot be told
/// apart.
class PublisherWatch {
 public:
  /// True for another publisher than the one that is heard, unless that has been silent for a second: then
  /// nothing that it said is of use any more (S4), and whoever speaks takes its place.
  bool isRival(const Sender& sender) const;

  /// Notes a message that was taken.
  void hear(const Sender& sender);

 private:
  std::string name_;
  Time newest_;
  bool heard_{false};
};

}  // namespace bs_car_odometry
