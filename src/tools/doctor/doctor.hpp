#pragma once

#include "../tool.hpp"
#include "finding.hpp"

#include <iosfwd>
#include <string>

namespace bs_car_odometry::tools::doctor {

struct Examination {
  Findings findings;
  Findings missing_topics;  ///< those of the findings that make a calibration impossible
  bool all_gains_observed{false};

  /// 3 with an ERROR among the findings, 2 when the drive does not show every gain, else 0.
  int exitStatus() const;
};

/// Looks through a bag before it is used for a calibration.
/// @throws InputError when it cannot be read as a bag, or holds no messages
Examination examine(const std::string& bag, const Parameters& parameters, const TopicNames& names);

/// Examines a bag and prints the findings.
/// @return the exit status  @throws InputError also when a topic is missing or of another type
int diagnose(const std::string& bag, const Parameters& parameters, const TopicNames& names,
             std::ostream& out);

}  // namespace bs_car_odometry::tools::doctor
