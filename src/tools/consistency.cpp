#include "simulated_consistency.hpp"
#include "tool.hpp"

int main(int argc, char** argv) {
  using namespace bs_car_odometry::tools;
  return runTool("consistency", [&] { consistency(argc, argv); });
}
