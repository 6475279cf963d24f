#include "simulated_drive_bag.hpp"
#include "tool.hpp"

int main(int argc, char** argv) {
  using namespace bs_car_odometry::tools;
  return runTool("simulate", [&] { simulate(argc, argv); });
}
