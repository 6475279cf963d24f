#include "recorded_consistency_tool.hpp"
#include "simulated_consistency.hpp"
#include "tool.hpp"

#include <algorithm>
#include <string>

int main(int argc, char** argv) {
  using namespace bs_car_odometry::tools;
  const bool recorded = std::any_of(argv + 1, argv + argc, [](const std::string& word) {
    return word == "--recorded" || word.rfind("--recorded=", 0) == 0;
  });
  return runTool("consistency",
                 [&] { recorded ? recordedConsistency(argc, argv) : consistency(argc, argv); });
}
