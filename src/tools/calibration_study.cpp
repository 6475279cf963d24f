#include "calibration_study_tool.hpp"
#include "tool.hpp"

int main(int argc, char** argv) {
  using namespace bs_car_odometry::tools;
  bool met = false;
  const int status = runTool("calibration_study", [&] { met = calibrationStudy(argc, argv); });
  return status == 0 && !met ? kTargetMissedStatus : status;
}
