#pragma once

#include <string>
#include <vector>

namespace bs_car_odometry::tools::testing {

/// A bag that no tool can use, and what a tool must say of it.
struct BadBag {
  std::string name;
  std::string path;
  std::vector<std::string> said;  ///< parts of the sentence: what was found, and the remedy
};

/// The corpus of row C10, written into `folder`: eight bags made from a good one of the Cycab.
std::vector<BadBag> writeBadBags(const std::string& folder);

}  // namespace bs_car_odometry::tools::testing
