#include "finding.hpp"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <iterator>
#include <ostream>
#include <utility>

namespace bs_car_odometry::tools::doctor {

namespace {

const char* label(Severity severity) {
  switch (severity) {
    case Severity::kError:
      return "ERROR  ";
    case Severity::kWarn:
      return "WARN   ";
    case Severity::kOk:
      break;
  }
  return "ok     ";
}

}  // namespace

Finding error(std::string text, std::string remedy) {
  return {Severity::kError, std::move(text), std::move(remedy)};
}

Finding warning(std::string text, std::string remedy) {
  return {Severity::kWarn, std::move(text), std::move(remedy)};
}

Finding fine(std::string text) { return {Severity::kOk, std::move(text), {}}; }

void append(Findings more, Findings& findings) {
  std::move(more.begin(), more.end(), std::back_inserter(findings));
}

void print(const Findings& findings, std::ostream& out) {
  Findings sorted = findings;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Finding& a, const Finding& b) { return a.severity < b.severity; });
  for (const Finding& finding : sorted) {
    out << label(finding.severity) << finding.text;
    if (!finding.remedy.empty()) out << ": " << finding.remedy;
    out << '\n';
  }
}

std::string format(const char* pattern, ...) {
  std::array<char, 512> text{};
  std::va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text.data(), text.size(), pattern, arguments);
  va_end(arguments);
  return text.data();
}

}  // namespace bs_car_odometry::tools::doctor
