#pragma once

#include "../tool.hpp"
#include "finding.hpp"

#include <map>
#include <string>
#include <vector>

namespace bs_car_odometry::tools::doctor {

/// A topic that a calibration reads, by the name that a remapping takes.
struct NeededTopic {
  std::string name;
  std::string type;
};

/// The topics that a calibration with these parameters cannot do without.
std::vector<NeededTopic> neededTopics(const Parameters& parameters);

/// An ERROR for each topic that is missing or of another type, with the remapping to give where the bag holds
/// topics of the right type under other names.
Findings checkTopics(const std::map<std::string, std::string>& types, const std::vector<NeededTopic>& needed,
                     const TopicNames& names);

}  // namespace bs_car_odometry::tools::doctor
