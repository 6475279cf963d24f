#pragma once

#include <iosfwd>
#include <string>
#include <vector>

/// What the tool `bag_doctor` is made of: one pass over a bag, then checks, each of which gives findings.
namespace bs_car_odometry::tools::doctor {

/// ERROR: a calibration from this bag would be wrong or impossible. WARN: it works, look at it.
enum class Severity { kError, kWarn, kOk };

/// One line of the report.
struct Finding {
  Severity severity{Severity::kOk};
  std::string text;
  std::string remedy;  ///< what to do about it; empty for kOk
};

using Findings = std::vector<Finding>;

Finding error(std::string text, std::string remedy);
Finding warning(std::string text, std::string remedy);
Finding fine(std::string text);

void append(Findings more, Findings& findings);

/// The worst first; findings of one severity stay in their order.
void print(const Findings& findings, std::ostream& out);

/// printf for the texts of findings.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...);

}  // namespace bs_car_odometry::tools::doctor
