#include "calibrate.hpp"
#include "tool.hpp"

int main(int argc, char** argv) {
  using namespace bs_car_odometry::tools;
  return runTool("calibrate_bag", [&] { calibrate(argc, argv); });
}
