#pragma once

#include "bag_input.hpp"
#include "tool.hpp"

#include "bs_car_odometry/core/odometry_pipeline.hpp"
#include "bs_car_odometry/parameters/parameters.hpp"

#include <string>
#include <utility>
#include <vector>

namespace bs_car_odometry::tools {

/// The topics that the odometry reads with these parameters.
class InputTopics {
 public:
  InputTopics(const Parameters& parameters, const TopicNames& names);

  /// One topic more.
  void require(const std::string& name, const std::string& type);

  const std::vector<WantedTopic>& required() const { return required_; }

  /// Of all that is required.
  std::vector<std::string> spellings() const;

 private:
  const TopicNames& names_;
  std::vector<WantedTopic> required_;
};

/// Why messages gave no pose: what was dropped, and why; "; 3 messages dropped: ...".
std::string reasons(const InputCounts& counts);

}  // namespace bs_car_odometry::tools
